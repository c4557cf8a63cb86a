#include "sim/drone_fence.h"

namespace colmap_ext {

void DroneFence::SetItems(const std::vector<MavMissionItemInt>& items, const GeoPosition& origin) {
  polygons_.clear();
  circles_.clear();
  const auto corner = [&](const MavMissionItemInt& item) {
    const GeoPosition place{item.x * 1e-7, item.y * 1e-7, origin.height_m};
    return Eigen::Vector2d(EnuFromGeo(origin, place).head<2>());
  };
  std::size_t missing = 0;  // vertices of the polygon at work
  for (const MavMissionItemInt& item : items) {
    const bool is_inclusion = item.command == MavCmd::kNavFencePolygonVertexInclusion ||
                              item.command == MavCmd::kNavFenceCircleInclusion;
    if (item.command == MavCmd::kNavFenceCircleInclusion ||
        item.command == MavCmd::kNavFenceCircleExclusion) {
      circles_.push_back({corner(item), static_cast<double>(item.param1), is_inclusion});
    } else if (item.command != MavCmd::kNavFenceReturnPoint) {
      if (missing == 0) {
        polygons_.push_back({{}, is_inclusion});
        missing = static_cast<std::size_t>(item.param1);
      }
      polygons_.back().corners.push_back(corner(item));
      --missing;
    }
  }
}

bool DroneFence::Contains(const Eigen::Vector2d& position, bool any_inclusion) const {
  int inclusions = 0, inside = 0;
  const auto count = [&](bool is_inclusion, bool contains) {
    if (!is_inclusion) return !contains;
    ++inclusions;
    inside += contains ? 1 : 0;
    return true;
  };
  for (const Polygon& polygon : polygons_) {
    if (!count(polygon.is_inclusion, IsInsideRing(polygon.corners, position))) return false;
  }
  for (const Circle& circle : circles_) {
    const bool contains = (circle.center - position).norm() <= circle.radius_m;
    if (!count(circle.is_inclusion, contains)) return false;
  }
  if (inclusions == 0) return true;
  return any_inclusion ? inside > 0 : inside == inclusions;
}

}  // namespace colmap_ext
