// Whether a vehicle may hover at a point or fly a straight line: everything that a planned path
// keeps, in pure functions, so that whoever flies it can ask again.
#pragma once

#include <Eigen/Core>
#include <string>

#include "colmap_ext/path/free_space.h"
#include "colmap_ext/scene/flight_limits.h"

namespace colmap_ext {

struct SegmentRules {
  // Least distance of the vehicle from the surface, metres, > 0.
  double safe_distance_m = 5;
  // The vehicle may be so far from the line that it is told to fly, metres, >= 0: everything below
  // is proved for all places within this of the line.
  double position_error_m = 0.5;
  // What is nearer than safe distance + position error + this is not proved, metres, > 0.001.
  double proof_tolerance_m = 0.02;
  // Highest z of the world that may be flown, metres; 0: none.
  double max_altitude_m = 0;
  // Geofence, no-fly zones and altitude limits.
  FlightLimits limits;
  // Space that nothing is known about may be flown through.
  bool unknown_is_free = false;

  double ClearanceOfLine() const { return safe_distance_m + position_error_m; }
};

// Proves that every ball of `radius_m` around a point of the segment is known to be free, by balls
// that cover the line, halved down to 5 cm: true is always right.
bool IsSegmentKnown(const FreeSpace& space, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double radius_m);

// Why a vehicle may not hover at `point`; empty when it may. "it is …"
std::string WhyNotHover(const FreeSpace& space, const SegmentRules& rules,
                        const Eigen::Vector3d& point);

// Why the straight line from a to b is not proved to be safe, the ends included; empty when it is:
// then every one of its points keeps the rules, not only samples of it. "it …"
std::string WhyNotFly(const FreeSpace& space, const SegmentRules& rules, const Eigen::Vector3d& a,
                      const Eigen::Vector3d& b);

}  // namespace colmap_ext
