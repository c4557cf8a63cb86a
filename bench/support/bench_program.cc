#include "bench_program.h"

#include "colmap_ext/util/error.h"

namespace colmap_ext {

ChildProcessResult RunColmapExt(std::vector<std::string> arguments,
                                const std::filesystem::path& log_path, const JobControl& job) {
  ChildProcessOptions options;
  options.arguments = std::move(arguments);
  options.arguments.insert(options.arguments.begin(), COLMAP_EXT_PROGRAM);
  options.log_path = log_path;
  std::filesystem::create_directories(log_path.parent_path());
  ChildProcessResult result = RunChildProcess(options, job);
  if (result.exit_code != 0) {
    throw Error("colmap_ext " + options.arguments[1] + " failed; see " + log_path.string());
  }
  return result;
}

Reconstruction BroughtToTruth(Reconstruction model, const std::map<std::string, Rigid3d>& pose_of,
                              bool true_poses) {
  const auto count = static_cast<Eigen::Index>(model.images.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  Eigen::Index k = 0;
  for (const auto& [id, image] : model.images) {
    from.col(k) = CameraCenter(image.cam_from_world);
    to.col(k++) = CameraCenter(pose_of.at(image.name));
  }
  TransformReconstruction(EstimateSimilarity(from, to), &model);
  if (!true_poses) return model;
  for (auto& [id, image] : model.images) image.cam_from_world = pose_of.at(image.name);
  return model;
}

}  // namespace colmap_ext
