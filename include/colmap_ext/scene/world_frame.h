// What is known about the world frame of a model, and the region people care about.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/polygon.h"

namespace colmap_ext {

struct WorldFrame {
  // True when the world is local ENU in metres, z up. Planning a flight needs it.
  bool is_metric_enu = false;
  // Origin of the ENU frame on Earth; absent for a local metric frame (indoors, pose file).
  std::optional<GeoPosition> origin;
};

// The part of the world that has to be covered: a box, and of it only what lies above a polygon
// when there is one.
struct RegionOfInterest {
  BoundingBox box;
  // In x and y, metres; a place is inside by IsInsideRings. Empty: the whole box. `box` bounds
  // them.
  std::vector<PolygonRing> rings = {};

  bool Contains(const Eigen::Vector3d& point_in_world) const;
};

WorldFrame ReadWorldFrame(const std::filesystem::path& path);
void WriteWorldFrame(const WorldFrame& frame, const std::filesystem::path& path);

}  // namespace colmap_ext
