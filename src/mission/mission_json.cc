#include <nlohmann/json.hpp>

#include "colmap_ext/mission/export_formats.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

Json StopToJson(const MissionStop& stop) {
  const auto optional = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  return {
      {"lat", stop.lat_deg},
      {"lon", stop.lon_deg},
      {"position_enu_m", Json::array({stop.position.x(), stop.position.y(), stop.position.z()})},
      {"relative_m", stop.height.relative_m},
      {"amsl_m", optional(stop.height.amsl_m)},
      {"ellipsoidal_m", optional(stop.height.ellipsoidal_m)},
      {"heading_deg", HeadingDeg(stop.direction)},
      {"pitch_deg", RadToDeg(stop.direction.pitch_rad)},
      {"view_id", stop.view_id}};
}

Json AreasToJson(const std::vector<std::vector<GeoPosition>>& areas) {
  Json json = Json::array();
  for (const std::vector<GeoPosition>& area : areas) {
    Json corners = Json::array();
    for (const GeoPosition& corner : area) {
      corners.push_back({{"lat", corner.lat_deg}, {"lon", corner.lon_deg}});
    }
    json.push_back(std::move(corners));
  }
  return json;
}

}  // namespace

std::string MissionJson(const Mission& mission, const MissionOptions& options) {
  Json home = StopToJson(mission.home);
  for (const char* key : {"position_enu_m", "heading_deg", "pitch_deg", "view_id"}) home.erase(key);
  Json json = {{"home", home}};
  json["undulation_m"] = mission.undulation_m ? Json(*mission.undulation_m) : Json(nullptr);
  json["speed_m_s"] = options.speed_m_s;
  json["length_m"] = mission.length_m;
  json["duration_s"] = mission.duration_s;
  json["stops"] = Json::array();
  for (const MissionStop& stop : mission.stops) json["stops"].push_back(StopToJson(stop));
  json["flights"] = Json::array();
  for (const BatteryFlight& flight : mission.flights) {
    json["flights"].push_back({{"first_stop", flight.first_waypoint},
                               {"last_stop", flight.last_waypoint},
                               {"battery_share", flight.battery_share}});
  }
  json["fence"] = AreasToJson(options.fence);
  json["no_fly"] = AreasToJson(options.no_fly);
  return json.dump(2) + "\n";
}

}  // namespace colmap_ext
