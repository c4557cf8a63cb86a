#include "colmap_ext/flight/flight_mission.h"

#include <cmath>
#include <set>

namespace colmap_ext {
namespace {

bool IsFileName(const std::string& name) {
  return !name.empty() && name.size() < 200 && name.front() != '.' &&
         name.find_first_of("/\\\n\r\t") == std::string::npos;
}

std::string CheckStops(const std::vector<FlightStop>& stops) {
  std::set<int> ids;
  std::set<std::string> photos;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const FlightStop& stop = stops[i];
    const std::string where = "stop " + std::to_string(i) + ": ";
    if (!stop.position.allFinite() || !std::isfinite(stop.direction.yaw_rad) ||
        !std::isfinite(stop.direction.pitch_rad)) {
      return where + "not a finite number";
    }
    if (stop.view_id < 0) continue;
    if (!ids.insert(stop.view_id).second) {
      return where + "view " + std::to_string(stop.view_id) + " occurs twice";
    }
    if (!IsFileName(stop.photo)) return where + "photo must be a file name without folders";
    if (!photos.insert(stop.photo).second) return where + stop.photo + " occurs twice";
  }
  return "";
}

std::string CheckLimits(const MissionLimits& limits) {
  if (!(limits.min_relative_height_m < limits.max_relative_height_m)) {
    return "limits: min_relative_height_m must be below max_relative_height_m";
  }
  if (!(limits.max_distance_m > 0)) return "limits: max_distance_m must be above 0";
  if (!limits.fence.empty() && limits.fence.size() < 3) {
    return "limits: fence_enu_m needs at least 3 corners";
  }
  for (const Eigen::Vector2d& corner : limits.fence) {
    if (!corner.allFinite()) return "limits: fence_enu_m: not a finite number";
  }
  return "";
}

const char* Name(AtEnd at_end) {
  switch (at_end) {
    case AtEnd::kHold:
      return "hold";
    case AtEnd::kReturn:
      return "return";
    case AtEnd::kLand:
      break;
  }
  return "land";
}

AtEnd ParseAtEnd(const JsonNode& node) {
  const std::string text = node.Text();
  for (const AtEnd at_end : {AtEnd::kHold, AtEnd::kReturn, AtEnd::kLand}) {
    if (text == Name(at_end)) return at_end;
  }
  node.Fail("must be hold, return or land");
}

template <typename T, typename Read>
void ReadIfThere(const JsonNode& object, const char* key, T* value, const Read& read) {
  if (const auto node = object.Find(key)) *value = read(*node);
}

double NumberOf(const JsonNode& node) { return node.Number(); }
bool BooleanOf(const JsonNode& node) { return node.Boolean(); }

MissionLimits LimitsFromJson(const JsonNode& node) {
  MissionLimits limits;
  ReadIfThere(node, "min_relative_height_m", &limits.min_relative_height_m, NumberOf);
  ReadIfThere(node, "max_relative_height_m", &limits.max_relative_height_m, NumberOf);
  ReadIfThere(node, "max_distance_m", &limits.max_distance_m, NumberOf);
  if (const auto fence = node.Find("fence_enu_m")) {
    for (const JsonNode& corner : fence->Items()) {
      const std::vector<JsonNode> xy = corner.Items();
      if (xy.size() != 2) corner.Fail("expected [x, y]");
      limits.fence.emplace_back(xy[0].Number(), xy[1].Number());
    }
  }
  return limits;
}

Json LimitsToJson(const MissionLimits& limits) {
  Json fence = Json::array();
  for (const Eigen::Vector2d& corner : limits.fence) fence.push_back({corner.x(), corner.y()});
  return {{"min_relative_height_m", limits.min_relative_height_m},
          {"max_relative_height_m", limits.max_relative_height_m},
          {"max_distance_m", limits.max_distance_m},
          {"fence_enu_m", fence}};
}

Json StopToJson(const FlightStop& stop) {
  Json json = {
      {"position_enu_m", {stop.position.x(), stop.position.y(), stop.position.z()}},
      {"yaw_deg", RadToDeg(stop.direction.yaw_rad)},
      {"pitch_deg", RadToDeg(stop.direction.pitch_rad)},
      {"view_id", stop.view_id},
  };
  if (stop.view_id >= 0) json["photo"] = stop.photo;
  return json;
}

}  // namespace

std::string FlightMission::Check() const {
  if (!IsValid(origin)) return "origin: latitude or longitude is out of range";
  if (revision < 1) return "revision must be at least 1";
  if (!(speed_m_s > 0 && speed_m_s <= 30)) return "speed_m_s must be above 0 and at most 30";
  if (!(safe_distance_m >= 0)) return "safe_distance_m must not be negative";
  if (!std::isfinite(undulation_m)) return "undulation_m: not a finite number";
  if (surface_path.empty() && !is_vouched) {
    return "without surface_path nothing can be proved about the way; \"vouched\": true says that "
           "a person vouches for it";
  }
  if (surface_path.empty() && !transit_z_m) {
    return "without surface_path, transit_z_m must say at what height every way is free";
  }
  const std::string complaint = CheckLimits(limits);
  return complaint.empty() ? CheckStops(stops) : complaint;
}

Eigen::Vector3d FlightMission::WorldFromAmsl(const GeoPosition& amsl) const {
  return EnuFromGeo(origin, {amsl.lat_deg, amsl.lon_deg, amsl.height_m + undulation_m});
}

GeoPosition FlightMission::AmslFromWorld(const Eigen::Vector3d& position_in_world) const {
  GeoPosition position = GeoFromEnu(origin, position_in_world);
  position.height_m -= undulation_m;
  return position;
}

Json MissionToJson(const FlightMission& mission) {
  Json stops = Json::array();
  for (const FlightStop& stop : mission.stops) stops.push_back(StopToJson(stop));
  Json json = {{"revision", mission.revision},
               {"origin",
                {{"lat", mission.origin.lat_deg},
                 {"lon", mission.origin.lon_deg},
                 {"height_m", mission.origin.height_m}}},
               {"undulation_m", mission.undulation_m},
               {"speed_m_s", mission.speed_m_s},
               {"safe_distance_m", mission.safe_distance_m},
               {"surface_path", mission.surface_path.string()},
               {"vouched", mission.is_vouched},
               {"at_end", Name(mission.at_end)},
               {"full_resolution", mission.full_resolution},
               {"limits", LimitsToJson(mission.limits)},
               {"stops", stops}};
  if (mission.home_z_m) json["home_z_m"] = *mission.home_z_m;
  if (mission.transit_z_m) json["transit_z_m"] = *mission.transit_z_m;
  return json;
}

FlightMission MissionFromJson(const Json& json, const std::string& name) {
  const JsonNode root(json, name);
  FlightMission mission;
  const JsonNode origin = root["origin"];
  mission.origin = {origin["lat"].Number(), origin["lon"].Number(), origin["height_m"].Number()};
  ReadIfThere(root, "revision", &mission.revision, [](const JsonNode& n) { return n.Integer(); });
  ReadIfThere(root, "undulation_m", &mission.undulation_m, NumberOf);
  ReadIfThere(root, "home_z_m", &mission.home_z_m, NumberOf);
  ReadIfThere(root, "transit_z_m", &mission.transit_z_m, NumberOf);
  ReadIfThere(root, "speed_m_s", &mission.speed_m_s, NumberOf);
  ReadIfThere(root, "safe_distance_m", &mission.safe_distance_m, NumberOf);
  ReadIfThere(root, "surface_path", &mission.surface_path,
              [](const JsonNode& node) { return node.Text(); });
  ReadIfThere(root, "vouched", &mission.is_vouched, BooleanOf);
  ReadIfThere(root, "full_resolution", &mission.full_resolution, BooleanOf);
  ReadIfThere(root, "at_end", &mission.at_end, ParseAtEnd);
  ReadIfThere(root, "limits", &mission.limits, LimitsFromJson);
  mission.stops = StopsFromJson(root["stops"]);
  const std::string complaint = mission.Check();
  if (!complaint.empty()) root.Fail(complaint);
  return mission;
}

std::vector<FlightStop> StopsFromJson(const JsonNode& node) {
  std::vector<FlightStop> stops;
  for (const JsonNode& item : node.Items()) {
    FlightStop stop;
    stop.position = item["position_enu_m"].Vector();
    stop.direction = {DegToRad(item["yaw_deg"].Number()), DegToRad(item["pitch_deg"].Number())};
    if (const auto id = item.Find("view_id")) stop.view_id = id->Integer();
    if (stop.view_id >= 0) stop.photo = item["photo"].Text();
    stops.push_back(stop);
  }
  const std::string complaint = CheckStops(stops);
  if (!complaint.empty()) node.Fail(complaint);
  return stops;
}

}  // namespace colmap_ext
