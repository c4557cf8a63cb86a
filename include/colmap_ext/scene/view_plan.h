// Planned views and the path that joins them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

struct PlannedView {
  int id = 0;                                          // unique in a session
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world (ENU), metres
  ViewDirection direction;
  double score = 0;  // sum of projection ratios of the uncovered iso-points that it sees, px²/m²
};

struct Waypoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world (ENU), metres
  ViewDirection direction;
  int view_id = -1;  // the view photographed here; -1: flown through without stopping
};

struct FlightPath {
  std::vector<Waypoint> waypoints;  // first one: where the vehicle is now
  double length_m = 0;
  double duration_s = 0;
  double min_clearance_m = 0;         // proved over the whole path
  std::vector<int> dropped_view_ids;  // views that no proved path reaches
};

}  // namespace colmap_ext
