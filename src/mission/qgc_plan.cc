#include "colmap_ext/mission/qgc_plan.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "mission/mission_items.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

// QGroundControl's AltitudeMode.
constexpr int kAltitudeRelative = 1;
constexpr int kAltitudeAmsl = 2;
// MAV_TYPE_QUADROTOR
constexpr int kQuadrotor = 2;
// MAV_AUTOPILOT
constexpr int kPx4 = 12;
constexpr int kArduPilot = 3;

int AltitudeMode(const MissionOptions& options) {
  return options.height_reference == "amsl" ? kAltitudeAmsl : kAltitudeRelative;
}

Json ItemsToJson(const std::vector<MissionItem>& items, const MissionOptions& options) {
  Json json = Json::array();
  for (const MissionItem& item : items) {
    Json params = Json::array();
    for (const double param : item.params) {
      params.push_back(std::isnan(param) ? Json(nullptr) : Json(param));
    }
    Json entry = {{"type", "SimpleItem"}};
    if (item.IsPlace()) {
      entry["AMSLAltAboveTerrain"] = nullptr;
      entry["Altitude"] = item.params[6];
      entry["AltitudeMode"] = AltitudeMode(options);
    }
    entry["autoContinue"] = true;
    entry["command"] = item.command;
    entry["doJumpId"] = json.size() + 1;
    entry["frame"] = item.frame;
    entry["params"] = std::move(params);
    json.push_back(std::move(entry));
  }
  return json;
}

Json Polygon(const std::vector<GeoPosition>& corners, bool is_inclusion) {
  Json ring = Json::array();
  for (const GeoPosition& corner : corners) {
    ring.push_back(Json::array({corner.lat_deg, corner.lon_deg}));
  }
  return {{"version", 1}, {"inclusion", is_inclusion}, {"polygon", ring}};
}

Json FencePolygons(const MissionOptions& options) {
  Json polygons = Json::array();
  for (const auto& area : options.fence) polygons.push_back(Polygon(area, true));
  for (const auto& area : options.no_fly) polygons.push_back(Polygon(area, false));
  return polygons;
}

}  // namespace

std::string QgcPlan(const Mission& mission, const MissionOptions& options) {
  const double home_amsl_m = mission.home.height.amsl_m.value_or(mission.frame_height_m);
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
        {"globalPlanAltitudeMode", AltitudeMode(options)},
        {"plannedHomePosition",
         Json::array({mission.home.lat_deg, mission.home.lon_deg, home_amsl_m})},
        {"items", ItemsToJson(MissionItems(mission, options), options)}}},
      {"geoFence",
       {{"version", 2}, {"circles", Json::array()}, {"polygons", FencePolygons(options)}}},
      {"rallyPoints", {{"version", 2}, {"points", Json::array()}}},
  };
  return plan.dump(2) + "\n";
}

std::string QgcPlan(const FlightPath& path, const WorldFrame& frame,
                    const MissionOptions& options) {
  return QgcPlan(PrepareMission(path, frame, options), options);
}

}  // namespace colmap_ext
