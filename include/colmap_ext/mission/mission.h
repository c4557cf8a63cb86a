// A path made ready for drones: stops on Earth, with every height that is known.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct MissionOptions {
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
  // What the height of the world frame's origin is above: "ellipsoidal", "amsl" (sea level), or
  // "unknown" (the GPS of many cameras does not say): then only relative heights are written.
  std::string frame_heights = "unknown";
  // Heights of waypoints, where the format has a choice: "relative" to home, "amsl", or
  // "ellipsoidal". Relative ones are the safest: they need no geoid and no common datum.
  std::string height_reference = "relative";
  // Height of the geoid over the ellipsoid, metres, or "auto": EGM96 from PROJ's data files.
  std::string geoid_undulation_m = "auto";
  // DJI: wpml:droneEnumValue (67 M30, 77 M3E, 89 M350, 91 M3D) and wpml:payloadEnumValue (52 M30,
  // 66 M3E).
  int dji_drone = 77;
  int dji_payload = 66;
  // Areas of which the vehicle stays inside, 3 or more corners each. Not bound to the command line,
  // see SetFence.
  std::vector<std::vector<GeoPosition>> fence;
  // Areas that may not be flown over, 3 or more corners each.
  std::vector<std::vector<GeoPosition>> no_fly;

  std::string Check() const;
};

// Section "Mission".
void BindOptions(OptionSet& set, MissionOptions* options);

// A height by each of its references; what is not known is empty.
struct KnownHeights {
  double relative_m = 0;  // above home
  std::optional<double> amsl_m;
  std::optional<double> ellipsoidal_m;
};

struct MissionStop {
  double lat_deg = 0;
  double lon_deg = 0;
  KnownHeights height;
  ViewDirection direction;
  int view_id = -1;                                    // -1: flown through
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world (ENU), metres
};

struct Mission {
  MissionStop home;  // on the ground; relative height 0
  std::vector<MissionStop> stops;
  double frame_height_m = 0;           // of home, in the frame's own datum
  std::optional<double> undulation_m;  // that was used
  double length_m = 0;
  double duration_s = 0;
  std::vector<BatteryFlight> flights;  // of `stops`; may be empty
};

// Throws Error when the frame has no origin on Earth or is not metric, when there is nothing to
// fly, when a waypoint is too low, or when `height_reference` asks for heights that are not known;
// UsageError for bad options.
Mission PrepareMission(const FlightPath& path, const WorldFrame& frame,
                       const MissionOptions& options);

// The polygons of `limits` as fence and no-fly areas. Their heights are left out: a no-fly zone
// that is limited in height is one at all heights. Holes of a fence become
// no-fly areas, holes of a no-fly zone are left out.
// Throws Error without an origin on Earth.
void SetFence(const FlightLimits& limits, const WorldFrame& frame, MissionOptions* options);

// The part of the path that one battery flies (its index in path.flights), as a path.
FlightPath PathOfFlight(const FlightPath& path, std::size_t flight);

// The heading in [0, 360).
double HeadingDeg(const ViewDirection& direction);

}  // namespace colmap_ext
