#include "colmap_ext/mission/mission.h"

#include <cmath>
#include <cstdlib>

#include "colmap_ext/mission/geoid.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

GeoPosition HomePosition(const WorldFrame& frame, const MissionOptions& options) {
  if (!frame.origin.has_value() || !IsValid(*frame.origin)) {
    throw Error(
        "mission: the model has no place on Earth (no GPS), so no autopilot could fly the plan; "
        "use photos with GPS");
  }
  if (!frame.is_metric_enu) {
    throw Error("mission: the model is not in metres, so no flight can be planned from it");
  }
  GeoPosition home = *frame.origin;
  if (options.home_lat_deg != 0 || options.home_lon_deg != 0) {
    home.lat_deg = options.home_lat_deg;
    home.lon_deg = options.home_lon_deg;
  }
  home.height_m -= options.home_below_origin_m;
  return home;
}

// One value for the whole mission: over a few kilometres it changes by centimetres.
std::optional<double> Undulation(const GeoPosition& home, const MissionOptions& options) {
  if (options.frame_heights == "unknown") return std::nullopt;
  if (options.geoid_undulation_m != "auto") {
    return std::strtod(options.geoid_undulation_m.c_str(), nullptr);
  }
  return GeoidUndulation(home.lat_deg, home.lon_deg);
}

MissionStop StopAt(const GeoPosition& place, double home_height_m,
                   const std::optional<double>& undulation_m, const MissionOptions& options) {
  MissionStop stop;
  stop.lat_deg = place.lat_deg;
  stop.lon_deg = place.lon_deg;
  stop.height.relative_m = place.height_m - home_height_m;
  if (options.frame_heights == "ellipsoidal") {
    stop.height.ellipsoidal_m = place.height_m;
    if (undulation_m) stop.height.amsl_m = place.height_m - *undulation_m;
  } else if (options.frame_heights == "amsl") {
    stop.height.amsl_m = place.height_m;
    if (undulation_m) stop.height.ellipsoidal_m = place.height_m + *undulation_m;
  }
  return stop;
}

void RequireReference(const MissionStop& home, const MissionOptions& options) {
  const bool is_known =
      options.height_reference == "relative" ||
      (options.height_reference == "amsl" ? home.height.amsl_m : home.height.ellipsoidal_m)
          .has_value();
  if (is_known) return;
  if (options.frame_heights == "unknown") {
    throw Error("mission: --Mission.height_reference " + options.height_reference +
                " needs to know what the model's heights are above: say --Mission.frame_heights "
                "ellipsoidal or amsl, or write relative heights");
  }
  throw Error("mission: --Mission.height_reference " + options.height_reference +
              " needs the height of the geoid here, and " + kEgm96Grid +
              " is not there: give it by --Mission.geoid_undulation_m, install proj-data, or write "
              "relative heights");
}

}  // namespace

double HeadingDeg(const ViewDirection& direction) {
  const double heading = RadToDeg(NormalizeAngle(direction.yaw_rad));
  return heading < 0 ? heading + 360 : heading;
}

Mission PrepareMission(const FlightPath& path, const WorldFrame& frame,
                       const MissionOptions& options) {
  ThrowIfInvalid(options.Check());
  const GeoPosition home = HomePosition(frame, options);
  if (path.waypoints.empty()) throw Error("mission: the path has no waypoints, nothing to fly");
  Mission mission;
  mission.frame_height_m = home.height_m;
  mission.undulation_m = Undulation(home, options);
  mission.home = StopAt(home, home.height_m, mission.undulation_m, options);
  RequireReference(mission.home, options);
  for (const Waypoint& waypoint : path.waypoints) {
    MissionStop stop = StopAt(GeoFromEnu(*frame.origin, waypoint.position), home.height_m,
                              mission.undulation_m, options);
    if (!(stop.height.relative_m >= options.min_relative_height_m)) {
      throw Error("mission: waypoint " + std::to_string(mission.stops.size()) + " is only " +
                  FormatNumber("%.2f", stop.height.relative_m) +
                  " m above home (least: " + FormatNumber("%.2f", options.min_relative_height_m) +
                  "); say how far the take-off place lies below the frame's origin by "
                  "--Mission.home_below_origin_m");
    }
    stop.direction = waypoint.direction;
    stop.view_id = waypoint.view_id;
    stop.position = waypoint.position;
    mission.stops.push_back(stop);
  }
  mission.length_m = path.length_m;
  mission.duration_s = path.duration_s;
  mission.flights = path.flights;
  return mission;
}

void SetFence(const FlightLimits& limits, const WorldFrame& frame, MissionOptions* options) {
  if (!frame.origin.has_value()) {
    throw Error("mission: the model has no place on Earth (no GPS), so a fence has none either");
  }
  for (const FlightZone& zone : limits.zones) {
    for (std::size_t i = 0; i < zone.rings.size(); ++i) {
      std::vector<GeoPosition> corners;
      for (const Eigen::Vector2d& corner : zone.rings[i]) {
        corners.push_back(GeoFromEnu(*frame.origin, {corner.x(), corner.y(), 0}));
      }
      const bool is_inclusion = (zone.kind == FlightZone::Kind::kInclusion) == (i == 0);
      // What is free within a no-fly zone may be left out, but is no fence around everything.
      if (is_inclusion && i > 0) continue;
      (is_inclusion ? options->fence : options->no_fly).push_back(corners);
    }
  }
}

FlightPath PathOfFlight(const FlightPath& path, std::size_t flight) {
  if (flight >= path.flights.size()) {
    throw Error("mission: the path has " + std::to_string(path.flights.size()) +
                " flights, there is no number " + std::to_string(flight + 1));
  }
  BatteryFlight part = path.flights[flight];
  FlightPath one;
  one.waypoints.assign(
      path.waypoints.begin() + static_cast<std::ptrdiff_t>(part.first_waypoint),
      path.waypoints.begin() + static_cast<std::ptrdiff_t>(part.last_waypoint) + 1);
  one.length_m = part.length_m;
  one.duration_s = part.duration_s;
  one.min_clearance_m = path.min_clearance_m;
  part.last_waypoint -= part.first_waypoint;
  part.first_waypoint = 0;
  one.flights = {part};
  return one;
}

}  // namespace colmap_ext
