#include "colmap_ext/mvs/neighbors.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

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
  const std::size_t n = photos.photos.size();
  std::vector<Eigen::Vector3d> centers;
  for (const PosedPhoto& photo : photos.photos)
    centers.push_back(CameraCenter(photo.cam_from_world));

  std::vector<std::unordered_map<int, double>> score(n);
  for (const SupportPoint& point : photos.points) {
    for (std::size_t a = 0; a < point.photo_indices.size(); ++a) {
      const int i = point.photo_indices[a];
      const Eigen::Vector3d ray_i = point.position - centers[static_cast<std::size_t>(i)];
      for (std::size_t b = a + 1; b < point.photo_indices.size(); ++b) {
        const int j = point.photo_indices[b];
        const Eigen::Vector3d ray_j = point.position - centers[static_cast<std::size_t>(j)];
        const double weight = AngleWeight(ray_i, ray_j, options);
        score[static_cast<std::size_t>(i)][j] += weight;
        score[static_cast<std::size_t>(j)][i] += weight;
      }
    }
  }

  std::vector<std::vector<int>> neighbors(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::pair<double, int>> ranked;
    for (const auto& [j, s] : score[i]) {
      if (s > 0) ranked.emplace_back(-s, j);
    }
    std::sort(ranked.begin(), ranked.end());
    const std::size_t count =
        std::min(ranked.size(), static_cast<std::size_t>(options.num_neighbors));
    for (std::size_t r = 0; r < count; ++r) neighbors[i].push_back(ranked[r].second);
  }
  return neighbors;
}

}  // namespace colmap_ext
