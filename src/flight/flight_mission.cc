#include "colmap_ext/flight/flight_mission.h"

#include <algorithm>
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

std::string CheckZones(const FlightLimits& site) {
  if (site.min_z_m > site.max_z_m) return "limits: min_z_m is above max_z_m";
  for (std::size_t i = 0; i < site.zones.size(); ++i) {
    const FlightZone& zone = site.zones[i];
    const std::string where = "limits: zone " + std::to_string(i) + ": ";
    if (zone.rings.empty()) return where + "rings_enu_m is empty";
    if (zone.min_z_m > zone.max_z_m) return where + "min_z_m is above max_z_m";
    for (const PolygonRing& ring : zone.rings) {
      if (ring.size() < 3) return where + "a ring needs at least 3 corners";
      const bool is_finite = std::all_of(ring.begin(), ring.end(),
                                         [](const auto& corner) { return corner.allFinite(); });
      if (!is_finite) return where + "not a finite number";
    }
  }
  return "";
}

// Whether stops and the straight ways between them are within the limits of the site.
std::string CheckWay(const std::vector<FlightStop>& stops, const FlightLimits& site) {
  if (site.IsEmpty()) return "";
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const std::string why = site.WhyNot(stops[i].position);
    if (!why.empty()) return "stop " + std::to_string(i) + " is " + why;
    if (i == 0) continue;
    if (!site.AllowsSegment(stops[i - 1].position, stops[i].position, 0)) {
      return "the way from stop " + std::to_string(i - 1) + " to stop " + std::to_string(i) +
             " leaves the flight limits";
    }
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

PolygonRing RingFromJson(const JsonNode& node) {
  PolygonRing ring;
  for (const JsonNode& corner : node.Items()) {
    const std::vector<JsonNode> xy = corner.Items();
    if (xy.size() != 2) corner.Fail("expected [x, y]");
    ring.emplace_back(xy[0].Number(), xy[1].Number());
  }
  return ring;
}

Json RingToJson(const PolygonRing& ring) {
  Json json = Json::array();
  for (const Eigen::Vector2d& corner : ring) json.push_back({corner.x(), corner.y()});
  return json;
}

FlightZone ZoneFromJson(const JsonNode& node) {
  FlightZone zone;
  const JsonNode kind = node["fence"];
  if (kind.Text() == "exclusion") {
    zone.kind = FlightZone::Kind::kExclusion;
  } else if (kind.Text() != "inclusion") {
    kind.Fail("must be inclusion or exclusion");
  }
  ReadIfThere(node, "name", &zone.name, [](const JsonNode& name) { return name.Text(); });
  for (const JsonNode& ring : node["rings_enu_m"].Items()) zone.rings.push_back(RingFromJson(ring));
  ReadIfThere(node, "min_z_m", &zone.min_z_m, NumberOf);
  ReadIfThere(node, "max_z_m", &zone.max_z_m, NumberOf);
  return zone;
}

// JSON has no infinity: a bound that is none is not written.
void SetIfFinite(const char* key, double value, Json* json) {
  if (std::isfinite(value)) (*json)[key] = value;
}

Json ZoneToJson(const FlightZone& zone) {
  Json rings = Json::array();
  for (const PolygonRing& ring : zone.rings) rings.push_back(RingToJson(ring));
  Json json = {{"fence", zone.kind == FlightZone::Kind::kExclusion ? "exclusion" : "inclusion"},
               {"name", zone.name},
               {"rings_enu_m", rings}};
  SetIfFinite("min_z_m", zone.min_z_m, &json);
  SetIfFinite("max_z_m", zone.max_z_m, &json);
  return json;
}

MissionLimits LimitsFromJson(const JsonNode& node) {
  MissionLimits limits;
  ReadIfThere(node, "min_relative_height_m", &limits.min_relative_height_m, NumberOf);
  ReadIfThere(node, "max_relative_height_m", &limits.max_relative_height_m, NumberOf);
  ReadIfThere(node, "max_distance_m", &limits.max_distance_m, NumberOf);
  ReadIfThere(node, "fence_enu_m", &limits.fence, RingFromJson);
  if (const auto zones = node.Find("zones")) {
    for (const JsonNode& zone : zones->Items()) limits.site.zones.push_back(ZoneFromJson(zone));
  }
  ReadIfThere(node, "min_z_m", &limits.site.min_z_m, NumberOf);
  ReadIfThere(node, "max_z_m", &limits.site.max_z_m, NumberOf);
  return limits;
}

Json LimitsToJson(const MissionLimits& limits) {
  Json json = {{"min_relative_height_m", limits.min_relative_height_m},
               {"max_relative_height_m", limits.max_relative_height_m},
               {"max_distance_m", limits.max_distance_m},
               {"fence_enu_m", RingToJson(limits.fence)}};
  if (!limits.site.zones.empty()) {
    Json zones = Json::array();
    for (const FlightZone& zone : limits.site.zones) zones.push_back(ZoneToJson(zone));
    json["zones"] = zones;
  }
  SetIfFinite("min_z_m", limits.site.min_z_m, &json);
  SetIfFinite("max_z_m", limits.site.max_z_m, &json);
  return json;
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
  std::string complaint = CheckLimits(limits);
  if (complaint.empty()) complaint = CheckZones(limits.site);
  if (complaint.empty()) complaint = CheckStops(stops);
  return complaint.empty() ? CheckWay(stops, limits.site) : complaint;
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
