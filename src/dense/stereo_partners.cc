#include "colmap_ext/dense/stereo_partners.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

double AngleScore(double angle_deg, const DenseStereoOptions& options) {
  if (angle_deg < options.min_angle_deg) return angle_deg / options.min_angle_deg;
  if (angle_deg <= options.good_angle_deg) return 1;
  return std::max(
      0.0, (options.max_angle_deg - angle_deg) / (options.max_angle_deg - options.good_angle_deg));
}

double PairScore(const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b,
                 const DenseStereoOptions& options) {
  const double a = ray_a.norm();
  const double b = ray_b.norm();
  if (!(a > 0 && b > 0)) return 0;
  const double angle = std::atan2(ray_a.cross(ray_b).norm(), ray_a.dot(ray_b));
  const double ratio = std::min(a, b) / std::max(a, b);
  return AngleScore(RadToDeg(angle), options) * ratio * ratio;
}

}  // namespace

std::vector<std::vector<int>> ChooseStereoPartners(const PhotoSet& photos,
                                                   const DenseStereoOptions& options) {
  const auto score = [&](const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b) {
    return PairScore(ray_a, ray_b, options);
  };
  return RankPartners(photos, score, options.num_partners);
}

DepthRange RangeOfDepths(std::vector<float> depths) {
  constexpr std::size_t kMinSamples = 5;
  if (depths.size() < kMinSamples) return {};
  std::sort(depths.begin(), depths.end());
  const double last = static_cast<double>(depths.size() - 1);
  const auto at = [&](double share) {
    return static_cast<double>(depths[static_cast<std::size_t>(std::lround(share * last))]);
  };
  return {0.7 * at(0.005), 1.5 * at(0.995)};
}

std::vector<std::vector<float>> DepthsOfPoints(const PhotoSet& photos) {
  std::vector<std::vector<float>> depths(photos.photos.size());
  for (const SupportPoint& point : photos.points) {
    for (const int i : point.photo_indices) {
      const auto photo = static_cast<std::size_t>(i);
      const double z = (photos.photos[photo].cam_from_world * point.position).z();
      if (z > 0) depths[photo].push_back(static_cast<float>(z));
    }
  }
  return depths;
}

}  // namespace colmap_ext
