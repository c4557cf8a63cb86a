#include "survey.h"

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "support/bench_program.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

}  // namespace

BenchSurvey MakeSurvey(const fs::path& work_path, int num_views, const JobControl& job) {
  const Workspace workspace(work_path / "church");
  const IterationFiles files{workspace.iteration(0)};
  if (!fs::exists(files.coverage_json())) {
    RunColmapExt(
        {"active_capture", "--workspace_path", workspace.root().string(), "--scene", "church",
         "--Session.vehicle", "embedded", "--Session.max_iterations", "1",
         "--Session.full_resolution", "1", "--InitialFlight.num_views", std::to_string(num_views)},
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
    WriteReconstructionBinary(BroughtToTruth(ReadReconstruction(survey.sfm_sparse),
                                             PoseOfPhoto(ReadTruePoses(survey.true_poses)), true),
                              survey.true_sparse);
  }
  return survey;
}

FastModel MakeFastModel(const BenchSurvey& survey, const fs::path& sparse, const fs::path& output,
                        const JobControl& job) {
  FastModel fast{output / "surface.ply", output / "dense", 0};
  fs::remove_all(output);
  fs::create_directories(output);
  fast.cpu_s += RunColmapExt({"superpixel_stereo", "--input_path", sparse.string(), "--image_path",
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
      RunColmapExt({"surface_reconstructor", "--input_path", (output / "fused.ply").string(),
                    "--output_path", fast.mesh.string(), "--RegionOfInterest.box", text},
                   output / "fast.log", job)
          .cpu_s;
  return fast;
}

}  // namespace colmap_ext
