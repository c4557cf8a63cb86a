// The geofence that a simulated vehicle obeys.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/polygon.h"
#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

class DroneFence {
 public:
  // From a fence list that DroneMissions accepted; corners in the ENU frame at `origin`.
  void SetItems(const std::vector<MavMissionItemInt>& items, const GeoPosition& origin);
  bool IsEmpty() const { return polygons_.empty() && circles_.empty(); }

  // Inside every inclusion and outside every exclusion (ArduPilot) or, with `any_inclusion`, inside
  // at least one inclusion (PX4).
  bool Contains(const Eigen::Vector2d& position_in_world, bool any_inclusion) const;

 private:
  struct Polygon {
    PolygonRing corners;
    bool is_inclusion = true;
  };
  struct Circle {
    Eigen::Vector2d center;
    double radius_m = 0;
    bool is_inclusion = true;
  };
  std::vector<Polygon> polygons_;
  std::vector<Circle> circles_;
};

}  // namespace colmap_ext
