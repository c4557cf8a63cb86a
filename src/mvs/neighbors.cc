#include "colmap_ext/mvs/neighbors.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

// What a point is worth that is seen along two rays, by the angle between them.
class AngleWeight {
 public:
  explicit AngleWeight(const SuperpixelStereoOptions& options)
      : good_rad_(DegToRad(options.good_angle_deg)),
        cos_good_(std::cos(good_rad_)),
        cos_max_(std::cos(DegToRad(options.max_angle_deg))) {}

  double operator()(const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b) const {
    const double cosine = ray_a.dot(ray_b) / std::sqrt(ray_a.squaredNorm() * ray_b.squaredNorm());
    if (!(cosine >= cos_max_)) return 0;
    if (cosine <= cos_good_) return 1;  // most points: without an arc tangent
    return std::atan2(ray_a.cross(ray_b).norm(), ray_a.dot(ray_b)) / good_rad_;
  }

 private:
  double good_rad_, cos_good_, cos_max_;
};

}  // namespace

std::vector<std::vector<int>> FindNeighbors(const PhotoSet& photos,
                                            const SuperpixelStereoOptions& options) {
  return RankPartners(photos, AngleWeight(options), options.num_neighbors);
}

}  // namespace colmap_ext
