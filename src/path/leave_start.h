#pragma once

#include "path/leg_planner.h"
#include "path/leg_table.h"

namespace colmap_ext {

// Clearances further than this are not told apart.
inline constexpr double kMaxClearance_m = 50;

// Where planning begins: `start` itself, or, when it is a little too near to the surface, the end
// of a straight leg away from it. Throws Error when neither is permitted.
Polyline LeaveStart(const LegPlanner& planner, const Eigen::Vector3d& start,
                    const PathOptions& options, const JobControl& job);

}  // namespace colmap_ext
