// What is known about the world frame of a model, and the region people care about.
#pragma once

#include <filesystem>
#include <optional>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct WorldFrame {
  // True when the world is local ENU in metres, z up. Planning a flight needs it.
  bool is_metric_enu = false;
  // Origin of the ENU frame on Earth; absent for a local metric frame (indoors, pose file).
  std::optional<GeoPosition> origin;
};

// Axis-aligned part of the world that has to be covered.
struct RegionOfInterest {
  BoundingBox box;
  bool Contains(const Eigen::Vector3d& point_in_world) const {
    return box.contains(point_in_world);
  }
};

WorldFrame ReadWorldFrame(const std::filesystem::path& path);
void WriteWorldFrame(const WorldFrame& frame, const std::filesystem::path& path);

}  // namespace colmap_ext
