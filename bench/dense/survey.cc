#include "survey.h"

#include <map>

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

Reconstruction WithTruePoses(Reconstruction model, const std::vector<TruePose>& poses) {
  std::map<std::string, Rigid3d> pose_of;
  for (const TruePose& pose : poses) pose_of[pose.name] = pose.cam_from_world;
  const auto count = static_cast<Eigen::Index>(model.images.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  Eigen::Index k = 0;
  for (const auto& [id, image] : model.images) {
    from.col(k) = CameraCenter(image.cam_from_world);
    to.col(k++) = CameraCenter(pose_of.at(image.name));
  }
  TransformReconstruction(EstimateSimilarity(from, to), &model);
  for (auto& [id, image] : model.images) image.cam_from_world = pose_of.at(image.name);
  return model;
}

}  // namespace

ChildProcessResult RunProgram(std::vector<std::string> arguments, const fs::path& log_path,
                              const JobControl& job) {
  ChildProcessOptions options;
  options.arguments = std::move(arguments);
  options.arguments.insert(options.arguments.begin(), COLMAP_EXT_PROGRAM);
  options.log_path = log_path;
  fs::create_directories(log_path.parent_path());
  ChildProcessResult result = RunChildProcess(options, job);
  if (result.exit_code != 0) {
    throw Error("colmap_ext " + options.arguments[1] + " failed; see " + log_path.string());
  }
  return result;
}

BenchSurvey MakeSurvey(const fs::path& work_path, int num_views, const JobControl& job) {
  const Workspace workspace(work_path / "church");
  const IterationFiles files{workspace.iteration(0)};
  if (!fs::exists(files.coverage_json())) {
    RunProgram({"active_capture", "--workspace_path", workspace.root().string(), "--scene",
                "church", "--Session.max_iterations", "1", "--Session.full_resolution", "1",
                "--InitialFlight.num_views", std::to_string(num_views)},
               work_path / "logs" / "active_capture.log", job);
  }
  BenchSurvey survey;
  survey.images_low = workspace.images();
  survey.images_full = workspace.images_full();
  survey.sfm_sparse = files.sparse();
  survey.true_poses = workspace.root() / "truth" / "poses.txt";
  survey.truth = ReadMesh(workspace.root() / "truth" / "model.ply");
  survey.true_sparse = work_path / "true_poses" / "sparse";
  if (!fs::exists(survey.true_sparse)) {
    WriteReconstructionBinary(
        WithTruePoses(ReadReconstruction(survey.sfm_sparse), ReadTruePoses(survey.true_poses)),
        survey.true_sparse);
  }
  return survey;
}

FastModel MakeFastModel(const BenchSurvey& survey, const fs::path& sparse, const fs::path& output,
                        const JobControl& job) {
  FastModel fast{output / "surface.ply", output / "dense", 0};
  fs::remove_all(output);
  fs::create_directories(output);
  fast.cpu_s += RunProgram({"superpixel_stereo", "--input_path", sparse.string(), "--image_path",
                            survey.images_low.string(), "--output_path", output.string()},
                           output / "fast.log", job)
                    .cpu_s;
  // The region of the truth, so that both models are meshed over the same box.
  const BoundingBox box = BoundsOf(survey.truth);
  std::string text;
  for (const double value : {box.min().x() - 2, box.min().y() - 2, box.min().z() - 1,
                             box.max().x() + 2, box.max().y() + 2, box.max().z() + 1}) {
    text += (text.empty() ? "" : ",") + std::to_string(value);
  }
  fast.cpu_s +=
      RunProgram({"surface_reconstructor", "--input_path", (output / "fused.ply").string(),
                  "--output_path", fast.mesh.string(), "--RegionOfInterest.box", text},
                 output / "fast.log", job)
          .cpu_s;
  return fast;
}

}  // namespace colmap_ext
