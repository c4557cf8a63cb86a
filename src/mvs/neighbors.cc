#include "colmap_ext/mvs/neighbors.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

double AngleWeight(const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b,
                   const SuperpixelStereoOptions& options) {
  const double angle = std::atan2(ray_a.cross(ray_b).norm(), ray_a.dot(ray_b));
  if (angle > DegToRad(options.max_angle_deg)) return 0;
  return std::min(1.0, angle / DegToRad(options.good_angle_deg));
}

}  // namespace

std::vector<std::vector<int>> FindNeighbors(const PhotoSet& photos,
                                            const SuperpixelStereoOptions& options) {
  const auto weight = [&](const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b) {
    return AngleWeight(ray_a, ray_b, options);
  };
  return RankPartners(photos, weight, options.num_neighbors);
}

}  // namespace colmap_ext
