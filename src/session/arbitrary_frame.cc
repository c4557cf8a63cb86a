#include "session/arbitrary_frame.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {

double TypicalViewingDistance(const CoverageOptions& options, const Reconstruction& model) {
  const PinholeCamera camera = ToPinhole(model.cameras.begin()->second);
  return camera.fx * options.ground_sampling_distance_mm / 1000.0 / 1.5;
}

void NormalizeArbitraryFrame(double distance_m, Reconstruction* model) {
  std::vector<double> distances;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const auto& [id, image] : model->images) {
    up -= image.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitY();
    const Eigen::Vector3d camera_center = CameraCenter(image.cam_from_world);
    center += camera_center / static_cast<double>(model->images.size());
    for (const Keypoint2D& keypoint : image.keypoints) {
      if (keypoint.point3D_id == kInvalidPoint3DId) continue;
      const auto point = model->points.find(keypoint.point3D_id);
      if (point != model->points.end()) {
        distances.push_back((point->second.position - camera_center).norm());
      }
    }
  }
  if (distances.empty()) throw Error("the sparse model has no points");
  // Cameras that look straight down have no upward axis in common; any frame will do then.
  if (up.norm() < 1e-6) up = Eigen::Vector3d::UnitZ();
  Sim3d new_from_old;
  new_from_old.scale = distance_m / MiddleValue(std::move(distances));
  new_from_old.rotation = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  new_from_old.translation = -new_from_old.scale * (new_from_old.rotation * center);
  TransformReconstruction(new_from_old, model);
}

}  // namespace colmap_ext
