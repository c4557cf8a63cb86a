#include "gauge.h"

#include <cmath>
#include <vector>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

std::vector<PosePair> CommonPoses(const Reconstruction& reference, const Reconstruction& moved) {
  std::vector<PosePair> poses;
  for (const auto& [id, image] : reference.images) {
    const auto found = moved.images.find(id);
    if (found == moved.images.end()) continue;
    poses.push_back({image.cam_from_world, found->second.cam_from_world});
  }
  return poses;
}

// Root mean square distance of the centres from their mean; 0 when it is only rounding.
double Spread(const std::vector<PosePair>& poses, Rigid3d PosePair::*pose) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : poses) mean += CameraCenter(pair.*pose);
  mean /= static_cast<double>(poses.size());
  double sum = 0;
  for (const PosePair& pair : poses) sum += (CameraCenter(pair.*pose) - mean).squaredNorm();
  const double spread = std::sqrt(sum / static_cast<double>(poses.size()));
  constexpr double kRounding = 1e-12;
  return spread > kRounding * mean.norm() ? spread : 0;
}

}  // namespace

std::optional<Sim3d> ReferenceFromMoved(const std::vector<PosePair>& poses) {
  if (poses.size() < 2) return std::nullopt;
  const double reference_spread = Spread(poses, &PosePair::cam_from_reference);
  const double moved_spread = Spread(poses, &PosePair::cam_from_moved);
  if (!(reference_spread > 0 && moved_spread > 0)) return std::nullopt;
  // Four points a camera: the centre, and one step along each of its axes. The step is as long as
  // the cameras are apart, in either model's own unit.
  const Eigen::Index count = static_cast<Eigen::Index>(4 * poses.size());
  Eigen::Matrix3Xd reference_points(3, count), moved_points(3, count);
  Eigen::Index column = 0;
  for (const PosePair& pair : poses) {
    for (int axis = -1; axis < 3; ++axis, ++column) {
      const Eigen::Vector3d step =
          axis < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(Eigen::Vector3d::Unit(axis));
      reference_points.col(column) = Inverse(pair.cam_from_reference) * (reference_spread * step);
      moved_points.col(column) = Inverse(pair.cam_from_moved) * (moved_spread * step);
    }
  }
  return EstimateSimilarity(moved_points, reference_points);
}

Sim3d ReferenceFromMoved(const Reconstruction& reference, const Reconstruction& moved) {
  const std::optional<Sim3d> reference_from_moved =
      ReferenceFromMoved(CommonPoses(reference, moved));
  if (reference_from_moved) return *reference_from_moved;
  throw Error(
      "the updated model shares fewer than 2 places with the old one; the old frame "
      "cannot be kept");
}

}  // namespace colmap_ext
