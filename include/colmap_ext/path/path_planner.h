// Joins planned views to a flight that is proved to keep its distance from the surface.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct PathOptions {
  // Least distance from the surface anywhere on the path, metres, > 0. Paper: its "safe distance".
  double safe_distance_m = 5;
  // Cells of the search grid, metres, > 0.
  double cell_size_m = 1;
  // How far beyond start, views and surface top the grid goes, for detours, metres, >= 0.
  double detour_margin_m = 10;
  // Ceiling: highest z of the world that may be flown, metres; 0: none.
  double max_altitude_m = 0;
  // "occupied": space that nothing is known about is not flown through; "free": it is.
  std::string unknown = "occupied";
  // See FreeSpaceOptions, metres, >= 0. The first flight is vouched to keep the safe distance from
  // everything. Less than the next best views' max_distance_to_existing_m makes the loop slow.
  double flown_margin_m = 5;
  // The vehicle is where it is: its place may be nearer to the surface than the safe distance by
  // this, metres, >= 0. It then leaves by a straight leg that never gets nearer than it is.
  double start_tolerance_m = 1;
  // Views and legs nearer than safe_distance_m + this are not proved, metres, 0.002 … 1. Smaller
  // values take more distance queries.
  double proof_tolerance_m = 0.02;
  // For the estimate of the duration: no acceleration, turns on the spot at a view.
  double speed_m_s = 3;        // (0, 30]
  double yaw_rate_deg_s = 45;  // (0, 360]
  double hover_s = 4;          // a photo: settling, aiming, capture; >= 0

  std::string Check() const;
};

// Section "Path".
void BindOptions(OptionSet& set, PathOptions* options);

// Throws Error when the world is not metric with z up: distances mean nothing then.
void RequireMetric(const WorldFrame& frame);

// Plans a path from `start` (world) over as many of `views` as can be reached (paper, Sec. "NBV
// Planning and Flight Path Planning"; order and proofs: docs/algorithms.md).
// 1. Cells nearer than the safe distance to `surface`, unknown ones (see FreeSpace) and those above
//    the ceiling are occupied. A straight leg between two views is taken where it can be proved;
//    else A* finds the shortest way through free cells, in three dimensions, each step proved; the
//    way is then pulled straight, and each new segment proved again.
// 2. Order: nearest neighbour by length of the legs, then 2-opt.
// 3. min_clearance_m is a proved lower bound over the whole path (at most 50 m).
// Views that are too near to the surface, in unknown space, or not reached by a proved leg are
// dropped: named in `dropped_view_ids` (in the order of `views`), each with its reason as a warning
// to `job`. The first waypoint is `start` (view_id -1). Each waypoint without a view has the
// direction of the next view. No views: a path of the start alone. `photos`: all registered ones,
// without pixels; where they were and what they saw is known free. Throws UsageError for bad
// options, Error when `start` is too near to the surface or the grid would have more than 200
// million cells.
FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job);

// Where PlanPath would let the vehicle hover, for the search of views: clearance, known space and
// ceiling as there (that a way leads to the place is not looked at). Thread-safe; holds copies of
// what it needs. Throws UsageError for bad options.
std::function<bool(const Eigen::Vector3d&)> FlyablePositions(const TriangleMesh& surface,
                                                             const std::vector<PosedPhoto>& photos,
                                                             const Eigen::Vector3d& start,
                                                             const PathOptions& options);

// Length over speed, plus a hover and the turn since the last photo at each view, seconds.
double EstimateDuration(const std::vector<Waypoint>& waypoints, const PathOptions& options);

}  // namespace colmap_ext
