// QGroundControl's mission file (.plan), for PX4 and ArduPilot.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct QgcPlanOptions {
  // "px4" (MAV_AUTOPILOT 12) or "ardupilot" (3).
  std::string autopilot = "px4";
  // Flying speed, m/s, (0, 30].
  double speed_m_s = 3;
  // Wait at a view before the photo, seconds, >= 0: the vehicle and its gimbal settle.
  double hold_s = 2;
  // Wait after the photo was asked for, seconds, >= 0. ArduCopter goes on at once without it.
  double capture_delay_s = 2;
  // Least height of the take-off above the home position, metres, > 0. The take-off goes at least
  // up to the first waypoint.
  double takeoff_height_m = 10;
  // Waypoints lower than this above the home position are refused, metres.
  double min_relative_height_m = 1;
  // The home (take-off) position; both 0: the origin of the world frame.
  double home_lat_deg = 0;
  double home_lon_deg = 0;
  // How far the take-off place lies below the origin of the world frame, metres.
  double home_below_origin_m = 0;
  // Geoid undulation: what to subtract from the frame's heights to get AMSL, metres. 0 when the
  // photos' GPS heights are AMSL already. Only the planned home position uses it; waypoints are
  // relative to home.
  double undulation_m = 0;
  // Corners of an inclusion fence; empty: none, else at least 3. Not bound to the command line.
  std::vector<GeoPosition> fence;

  std::string Check() const;
};

// Section "Mission".
void BindOptions(OptionSet& set, QgcPlanOptions* options);

// The JSON text of a plan of plain SimpleItems: take-off, speed, then for each view gimbal →
// waypoint with hold and heading → capture → delay, for other waypoints the waypoint alone, and
// return to launch. ArduCopter ignores a waypoint's heading, so it also gets a heading command and
// a delay to turn, after the waypoint (a new waypoint would reset it). Altitudes are relative to
// home. The leg from home to the first waypoint and the return are the autopilot's own: not proved
// here. Throws Error when the frame has no origin on Earth, when there is nothing to fly, or when a
// waypoint is too low; UsageError for bad options.
std::string QgcPlan(const FlightPath& path, const WorldFrame& frame, const QgcPlanOptions& options);

// Latitude, longitude and height of the home position that the options describe.
GeoPosition HomePosition(const WorldFrame& frame, const QgcPlanOptions& options);

}  // namespace colmap_ext
