// How long a flight takes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

// Seconds from hover at `from` to hover at `to`, in a straight line: the longer of the level and
// the vertical part, each with constant acceleration up to its speed and down again,
//   t(d) = d / v + v / a where d >= v² / a, else 2 sqrt(d / a).
// Every waypoint is taken as a stop, also where the autopilot would round a corner.
double TimeBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   const PathOptions& options);

// The times between waypoints, plus a hover and the turn since the last photo (on the spot) at each
// view, seconds. Without take-off and landing.
double EstimateDuration(const std::vector<Waypoint>& waypoints, const PathOptions& options);

// The views flown in their order, straight from one to the next, from the first one on; before the
// straight way home would take more than the battery has, it is flown, and the next flight begins
// there (options.home; empty: the first view). Nothing is proved (min_clearance_m = 0): for
// patterns that are flown before there is a model, and for which the pilot vouches. A view that is
// further than a battery carries is dropped with its reason.
FlightPath FlyInOrder(const std::vector<PlannedView>& views, const PathOptions& options);

}  // namespace colmap_ext
