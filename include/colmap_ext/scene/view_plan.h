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

// A part of a path that one battery flies.
struct BatteryFlight {
  std::size_t first_waypoint = 0;  // of FlightPath::waypoints
  std::size_t last_waypoint = 0;   // included; the next flight begins at it
  double length_m = 0;
  double duration_s = 0;
  // From the last view home: within the flight when its waypoints lead home, else still to fly.
  double return_s = 0;
  // Part of a full battery that is used when the vehicle has landed at home, 0 … 1.
  double battery_share = 0;
};

struct FlightPath {
  std::vector<Waypoint> waypoints;  // first one: where the vehicle is now
  double length_m = 0;
  double duration_s = 0;
  double min_clearance_m = 0;             // proved over the whole path
  std::vector<int> dropped_view_ids;      // views that no proved path reaches
  std::vector<std::string> drop_reasons;  // one a dropped view; empty: not told
  std::vector<BatteryFlight> flights;     // in order; empty: not split
};

}  // namespace colmap_ext
