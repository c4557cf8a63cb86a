#include "colmap_ext/geom/polygon.h"

#include <algorithm>
#include <limits>

namespace colmap_ext {
namespace {

double DistanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double squared_length = along.squaredNorm();
  const double t =
      squared_length > 0 ? std::clamp((point - a).dot(along) / squared_length, 0.0, 1.0) : 0.0;
  return (point - a - t * along).norm();
}

}  // namespace

bool IsInsideRing(const PolygonRing& ring, const Eigen::Vector2d& point) {
  bool is_inside = false;  // whether a ray from the point towards +x crosses an odd number of edges
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d& a = ring[i];
    const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double crossing = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < crossing) is_inside = !is_inside;
  }
  return is_inside;
}

bool IsInsideRings(const std::vector<PolygonRing>& rings, const Eigen::Vector2d& point) {
  return std::count_if(rings.begin(), rings.end(),
                       [&](const PolygonRing& ring) { return IsInsideRing(ring, point); }) %
             2 ==
         1;
}

double DistanceToBorder(const PolygonRing& ring, const Eigen::Vector2d& point) {
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    distance = std::min(distance, DistanceToSegment(point, ring[i], ring[(i + 1) % ring.size()]));
  }
  return distance;
}

double SignedArea(const PolygonRing& ring) {
  double twice_area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d& a = ring[i];
    const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice_area;
}

}  // namespace colmap_ext
