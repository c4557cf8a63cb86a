#include "coverage/convex_hull.h"

#include <algorithm>

namespace colmap_ext {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  // Andrew's monotone chain: the lower side from left to right, then the upper one back.
  std::vector<Eigen::Vector2d> hull;
  const auto extend = [&hull](const Eigen::Vector2d& point, std::size_t fixed) {
    while (hull.size() > fixed &&
           Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Eigen::Vector2d& point : points) extend(point, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) extend(points[i], lower);
  hull.pop_back();
  return hull;
}

bool IsInside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& point) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& corner = hull[i];
    if (Cross(hull[(i + 1) % hull.size()] - corner, point - corner) < 0) return false;
  }
  return true;
}

}  // namespace colmap_ext
