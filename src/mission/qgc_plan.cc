#include "colmap_ext/mission/qgc_plan.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

// MAV_CMD
constexpr int kWaypoint = 16;
constexpr int kReturnToLaunch = 20;
constexpr int kTakeoff = 22;
constexpr int kDelay = 93;
constexpr int kConditionYaw = 115;
constexpr int kChangeSpeed = 178;
constexpr int kGimbalPitchYaw = 1000;
constexpr int kStartCapture = 2000;
// MAV_FRAME
constexpr int kFrameMission = 2;
constexpr int kFrameRelative = 3;
// QGroundControl's AltitudeMode "relative to home".
constexpr int kAltitudeRelative = 1;
// MAV_TYPE_QUADROTOR
constexpr int kQuadrotor = 2;
constexpr int kPx4 = 12;
constexpr int kArduPilot = 3;

// The heading in [0, 360), as MAVLink's CONDITION_YAW wants it.
double HeadingDeg(const ViewDirection& direction) {
  const double heading = RadToDeg(NormalizeAngle(direction.yaw_rad));
  return heading < 0 ? heading + 360 : heading;
}

// Builds the items in order, numbering them.
class ItemList {
 public:
  // An item without a place. `params` are the seven of MAVLink; null stands for NaN.
  void AddCommand(int command, const Json& params) {
    items_.push_back({{"type", "SimpleItem"},
                      {"autoContinue", true},
                      {"command", command},
                      {"doJumpId", items_.size() + 1},
                      {"frame", kFrameMission},
                      {"params", params}});
  }

  // A take-off or waypoint; `params` are the first four.
  void AddPlace(int command, Json params, const GeoPosition& place, double relative_height_m) {
    params.push_back(place.lat_deg);
    params.push_back(place.lon_deg);
    params.push_back(relative_height_m);
    items_.push_back({{"type", "SimpleItem"},
                      {"AMSLAltAboveTerrain", nullptr},
                      {"Altitude", relative_height_m},
                      {"AltitudeMode", kAltitudeRelative},
                      {"autoContinue", true},
                      {"command", command},
                      {"doJumpId", items_.size() + 1},
                      {"frame", kFrameRelative},
                      {"params", params}});
  }

  const Json& items() const { return items_; }

 private:
  Json items_ = Json::array();
};

// A waypoint on Earth.
struct Stop {
  GeoPosition place;
  double relative_height_m = 0;
};

std::vector<Stop> StopsOnEarth(const FlightPath& path, const GeoPosition& origin,
                               const GeoPosition& home, const QgcPlanOptions& options) {
  std::vector<Stop> stops;
  for (std::size_t i = 0; i < path.waypoints.size(); ++i) {
    const GeoPosition place = GeoFromEnu(origin, path.waypoints[i].position);
    const double relative_height_m = place.height_m - home.height_m;
    if (!(relative_height_m >= options.min_relative_height_m)) {
      throw Error("mission: waypoint " + std::to_string(i) + " is only " +
                  std::to_string(relative_height_m) +
                  " m above home (least: " + std::to_string(options.min_relative_height_m) +
                  "); say how far the take-off place lies below the frame's origin by "
                  "--Mission.home_below_origin_m");
    }
    stops.push_back({place, relative_height_m});
  }
  return stops;
}

void AddView(const Waypoint& waypoint, const Stop& stop, int photo_number,
             const QgcPlanOptions& options, ItemList* items) {
  const double heading_deg = HeadingDeg(waypoint.direction);
  // Gimbal: pitch, yaw 0 (straight ahead of the vehicle, which turns), rates 0 (ArduPilot refuses
  // NaN there), flags 0, -, device 0.
  items->AddCommand(kGimbalPitchYaw, {RadToDeg(waypoint.direction.pitch_rad), 0, 0, 0, 0, 0, 0});
  items->AddPlace(kWaypoint, {options.hold_s, 0, 0, heading_deg}, stop.place,
                  stop.relative_height_m);
  if (options.autopilot == "ardupilot") {
    items->AddCommand(kConditionYaw, {heading_deg, 0, 0, 0, 0, 0, 0});
    items->AddCommand(kDelay, {std::max(1.0, options.hold_s), -1, -1, -1, 0, 0, 0});
  }
  items->AddCommand(kStartCapture, {0, 0, 1, photo_number, nullptr, nullptr, nullptr});
  items->AddCommand(kDelay, {options.capture_delay_s, -1, -1, -1, 0, 0, 0});
}

Json Items(const FlightPath& path, const std::vector<Stop>& stops, const GeoPosition& home,
           const QgcPlanOptions& options) {
  ItemList items;
  items.AddPlace(kTakeoff, {0, 0, 0, nullptr}, home,
                 std::max(options.takeoff_height_m, stops.front().relative_height_m));
  items.AddCommand(kChangeSpeed, {1, options.speed_m_s, -1, 0, 0, 0, 0});
  int photo_number = 0;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    if (path.waypoints[i].view_id >= 0) {
      AddView(path.waypoints[i], stops[i], ++photo_number, options, &items);
    } else {
      items.AddPlace(kWaypoint, {0, 0, 0, nullptr}, stops[i].place, stops[i].relative_height_m);
    }
  }
  items.AddCommand(kReturnToLaunch, {0, 0, 0, 0, 0, 0, 0});
  return items.items();
}

Json FencePolygons(const std::vector<GeoPosition>& fence) {
  Json polygons = Json::array();
  if (fence.empty()) return polygons;
  Json corners = Json::array();
  for (const GeoPosition& corner : fence) {
    corners.push_back(Json::array({corner.lat_deg, corner.lon_deg}));
  }
  polygons.push_back({{"version", 1}, {"inclusion", true}, {"polygon", corners}});
  return polygons;
}

}  // namespace

std::string QgcPlanOptions::Check() const {
  if (autopilot != "px4" && autopilot != "ardupilot") {
    return "Mission.autopilot must be px4 or ardupilot";
  }
  if (!(speed_m_s > 0 && speed_m_s <= 30)) return "Mission.speed_m_s must be in (0, 30]";
  if (!(hold_s >= 0 && hold_s <= 600)) return "Mission.hold_s must be in 0 … 600";
  if (!(capture_delay_s >= 0 && capture_delay_s <= 600)) {
    return "Mission.capture_delay_s must be in 0 … 600";
  }
  if (!(takeoff_height_m > 0 && takeoff_height_m <= 1000)) {
    return "Mission.takeoff_height_m must be in (0, 1000]";
  }
  if (!std::isfinite(min_relative_height_m) || !std::isfinite(home_below_origin_m) ||
      !std::isfinite(undulation_m)) {
    return "Mission heights must be finite (metres)";
  }
  if (!IsValid({home_lat_deg, home_lon_deg, 0})) {
    return "Mission.home_lat_deg must be in -90 … 90 and Mission.home_lon_deg in -180 … 180";
  }
  if (!fence.empty() && fence.size() < 3) return "a fence needs at least 3 corners";
  return "";
}

void BindOptions(OptionSet& set, QgcPlanOptions* options) {
  const std::string s = "Mission";
  set.Add(s, "autopilot", &options->autopilot, "px4 or ardupilot");
  set.Add(s, "speed_m_s", &options->speed_m_s, "flying speed (m/s, 0 … 30)");
  set.Add(s, "hold_s", &options->hold_s, "wait before a photo (seconds, 0 … 600)");
  set.Add(s, "capture_delay_s", &options->capture_delay_s, "wait after a photo (seconds, 0 … 600)");
  set.Add(s, "takeoff_height_m", &options->takeoff_height_m,
          "least height of the take-off above home (metres, 0 … 1000)");
  set.Add(s, "min_relative_height_m", &options->min_relative_height_m,
          "refuse waypoints lower than this above home (metres)");
  set.Add(s, "home_lat_deg", &options->home_lat_deg,
          "latitude of the take-off place; both 0: the frame's origin");
  set.Add(s, "home_lon_deg", &options->home_lon_deg, "longitude of the take-off place");
  set.Add(s, "home_below_origin_m", &options->home_below_origin_m,
          "how far the take-off place lies below the frame's origin (metres)");
  set.Add(s, "undulation_m", &options->undulation_m,
          "height of the geoid over the datum of the frame's heights (metres)");
}

GeoPosition HomePosition(const WorldFrame& frame, const QgcPlanOptions& options) {
  if (!frame.origin.has_value() || !IsValid(*frame.origin)) {
    throw Error(
        "mission: the model has no place on Earth (no GPS), so no autopilot could fly the plan; "
        "use photos with GPS, or export --format json");
  }
  GeoPosition home = *frame.origin;
  if (options.home_lat_deg != 0 || options.home_lon_deg != 0) {
    home.lat_deg = options.home_lat_deg;
    home.lon_deg = options.home_lon_deg;
  }
  home.height_m -= options.home_below_origin_m;
  return home;
}

std::string QgcPlan(const FlightPath& path, const WorldFrame& frame,
                    const QgcPlanOptions& options) {
  ThrowIfInvalid(options.Check());
  const GeoPosition home = HomePosition(frame, options);
  if (!frame.is_metric_enu) {
    throw Error("mission: the model is not in metres, so no flight can be planned from it");
  }
  if (path.waypoints.empty()) throw Error("mission: the path has no waypoints, nothing to fly");
  const std::vector<Stop> stops = StopsOnEarth(path, *frame.origin, home, options);

  const Json home_amsl =
      Json::array({home.lat_deg, home.lon_deg, home.height_m - options.undulation_m});
  const Json plan = {
      {"fileType", "Plan"},
      {"version", 1},
      {"groundStation", "QGroundControl"},
      {"mission",
       {{"version", 2},
        {"firmwareType", options.autopilot == "px4" ? kPx4 : kArduPilot},
        {"vehicleType", kQuadrotor},
        {"cruiseSpeed", options.speed_m_s},
        {"hoverSpeed", options.speed_m_s},
        {"globalPlanAltitudeMode", kAltitudeRelative},
        {"plannedHomePosition", home_amsl},
        {"items", Items(path, stops, home, options)}}},
      {"geoFence",
       {{"version", 2}, {"circles", Json::array()}, {"polygons", FencePolygons(options.fence)}}},
      {"rallyPoints", {{"version", 2}, {"points", Json::array()}}},
  };
  return plan.dump(2) + "\n";
}

}  // namespace colmap_ext
