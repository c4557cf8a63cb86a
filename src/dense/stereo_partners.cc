#include "colmap_ext/dense/stereo_partners.h"

#include <algorithm>
#include <cmath>
#include <map>

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
  const std::size_t n = photos.photos.size();
  std::vector<Eigen::Vector3d> centers;
  for (const PosedPhoto& photo : photos.photos)
    centers.push_back(CameraCenter(photo.cam_from_world));

  std::vector<std::map<int, double>> score(n);
  for (const SupportPoint& point : photos.points) {
    for (std::size_t a = 0; a < point.photo_indices.size(); ++a) {
      const auto i = static_cast<std::size_t>(point.photo_indices[a]);
      for (std::size_t b = a + 1; b < point.photo_indices.size(); ++b) {
        const auto j = static_cast<std::size_t>(point.photo_indices[b]);
        const double gain =
            PairScore(point.position - centers[i], point.position - centers[j], options);
        if (!(gain > 0)) continue;
        score[i][static_cast<int>(j)] += gain;
        score[j][static_cast<int>(i)] += gain;
      }
    }
  }

  std::vector<std::vector<int>> partners(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::pair<double, int>> ranked;
    for (const auto& [j, s] : score[i]) ranked.emplace_back(-s, j);
    std::sort(ranked.begin(), ranked.end());
    const auto wanted = static_cast<std::size_t>(options.num_partners);
    if (ranked.size() > wanted) ranked.resize(wanted);
    for (const auto& [s, j] : ranked) partners[i].push_back(j);
  }
  return partners;
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
