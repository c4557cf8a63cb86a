// The daemon's own checks of where the vehicle may fly: pure functions.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/geom/ray_scene.h"

namespace colmap_ext {

// What segments are checked against. Positions are in the mission's world.
struct FlightSpace {
  MissionLimits limits;
  Eigen::Vector3d home = Eigen::Vector3d::Zero();
  double safe_distance_m = 0;
  // Clearance is proved down to safe_distance_m - slack_m: the vehicle starts a segment where it
  // is, not where it should be.
  double slack_m = 0.6;
  const RayScene* surface = nullptr;  // null: nothing is known
};

// Why the vehicle may not fly straight from `from` to `to`; empty: it may. Fence and distance are
// checked for the whole segment, heights at its ends (they are extreme there), clearance at every
// point (ProveClearance; a start that is nearer than the safe distance may be left by a segment
// that does not come nearer). A start outside of fence or heights is no reason: the vehicle is
// where it is and may come back.
std::string CheckSegment(const FlightSpace& space, const Eigen::Vector3d& from,
                         const Eigen::Vector3d& to);

// Whether the point is inside the polygon (even-odd rule; the border counts as inside).
bool IsInsidePolygon(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point);

// The points to fly to, in order, to come from `from` to `to`: {to}, or, where the straight line is
// refused or `must_detour`, up to `transit_z_m`, over, and down. Empty, with the reason in
// `complaint`, when neither way is allowed.
std::vector<Eigen::Vector3d> PlanLegs(const FlightSpace& space, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to, std::optional<double> transit_z_m,
                                      bool must_detour, std::string* complaint);

// Battery, percent, that `way_m` metres flown, `hover_s` seconds of hovering and then the return
// from there (`return_m` horizontally, `height_m` down) take.
struct EnergyNeed {
  double way_m = 0;
  double hover_s = 0;
  double return_m = 0;
  double height_m = 0;
};
double BatteryNeeded(const EnergyNeed& need, double speed_m_s, double percent_per_minute);

}  // namespace colmap_ext
