#include "colmap_ext/eval/camera_poses.h"

#include "colmap_ext/scene/true_poses.h"

namespace colmap_ext {

std::map<std::string, Rigid3d> ReadCameraPoses(const std::filesystem::path& path) {
  return PoseOfPhoto(ReadTruePoses(path));
}

}  // namespace colmap_ext
