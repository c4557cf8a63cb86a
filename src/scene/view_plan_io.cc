#include "colmap_ext/scene/view_plan_io.h"

#include <set>
#include <string>

#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {
namespace {

void AddPose(const Eigen::Vector3d& position, const ViewDirection& direction,
             const WorldFrame& frame, Json* json) {
  (*json)["position_enu_m"] = {position.x(), position.y(), position.z()};
  if (frame.origin && position.allFinite()) {
    const GeoPosition geo = GeoFromEnu(*frame.origin, position);
    (*json)["lat"] = geo.lat_deg;
    (*json)["lon"] = geo.lon_deg;
    (*json)["height_m"] = geo.height_m;
  }
  (*json)["yaw_deg"] = RadToDeg(direction.yaw_rad);
  (*json)["pitch_deg"] = RadToDeg(direction.pitch_rad);
}

ViewDirection ReadDirection(const JsonNode& node) {
  return {.yaw_rad = DegToRad(node["yaw_deg"].Number()),
          .pitch_rad = DegToRad(node["pitch_deg"].Number())};
}

Json FlightsToJson(const std::vector<BatteryFlight>& flights) {
  Json json = Json::array();
  for (const BatteryFlight& flight : flights) {
    json.push_back({{"first_waypoint", flight.first_waypoint},
                    {"last_waypoint", flight.last_waypoint},
                    {"length_m", flight.length_m},
                    {"duration_s", flight.duration_s},
                    {"return_s", flight.return_s},
                    {"battery_share", flight.battery_share}});
  }
  return json;
}

std::size_t ReadWaypointIndex(const JsonNode& node, std::size_t num_waypoints) {
  const int index = node.Integer();
  if (index < 0 || static_cast<std::size_t>(index) >= num_waypoints) {
    node.Fail("there is no such waypoint");
  }
  return static_cast<std::size_t>(index);
}

std::vector<BatteryFlight> ReadFlights(const JsonNode& root, std::size_t num_waypoints) {
  std::vector<BatteryFlight> flights;
  const std::optional<JsonNode> list = root.Find("flights");
  if (!list) return flights;
  for (const JsonNode& node : list->Items()) {
    BatteryFlight flight;
    flight.first_waypoint = ReadWaypointIndex(node["first_waypoint"], num_waypoints);
    flight.last_waypoint = ReadWaypointIndex(node["last_waypoint"], num_waypoints);
    flight.length_m = node["length_m"].Number();
    flight.duration_s = node["duration_s"].Number();
    flight.return_s = node["return_s"].Number();
    flight.battery_share = node["battery_share"].Number();
    flights.push_back(flight);
  }
  return flights;
}

}  // namespace

void WriteViews(const std::vector<PlannedView>& views, const WorldFrame& frame,
                const std::filesystem::path& path) {
  Json json = Json::array();
  for (const PlannedView& view : views) {
    Json item;
    item["id"] = view.id;
    AddPose(view.position, view.direction, frame, &item);
    item["score"] = view.score;
    json.push_back(std::move(item));
  }
  WriteJsonFile(json, path);
}

std::vector<PlannedView> ReadViews(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  std::vector<PlannedView> views;
  std::set<int> ids;
  for (const JsonNode& node : JsonNode(json, path).Items()) {
    PlannedView view;
    view.id = node["id"].Integer();
    view.position = node["position_enu_m"].Vector();
    view.direction = ReadDirection(node);
    view.score = node["score"].Number();
    if (!ids.insert(view.id).second) {
      node["id"].Fail("id " + std::to_string(view.id) + " occurs twice");
    }
    views.push_back(view);
  }
  return views;
}

void WritePath(const FlightPath& flight_path, const WorldFrame& frame,
               const std::filesystem::path& path) {
  Json json;
  json["waypoints"] = Json::array();
  for (const Waypoint& waypoint : flight_path.waypoints) {
    Json item;
    AddPose(waypoint.position, waypoint.direction, frame, &item);
    item["view_id"] = waypoint.view_id;
    json["waypoints"].push_back(std::move(item));
  }
  json["length_m"] = flight_path.length_m;
  json["duration_s"] = flight_path.duration_s;
  json["min_clearance_m"] = flight_path.min_clearance_m;
  json["dropped_view_ids"] = flight_path.dropped_view_ids;
  json["drop_reasons"] = flight_path.drop_reasons;
  json["flights"] = FlightsToJson(flight_path.flights);
  WriteJsonFile(json, path);
}

FlightPath ReadPath(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  FlightPath flight_path;
  for (const JsonNode& node : root["waypoints"].Items()) {
    Waypoint waypoint;
    waypoint.position = node["position_enu_m"].Vector();
    waypoint.direction = ReadDirection(node);
    waypoint.view_id = node["view_id"].Integer();
    flight_path.waypoints.push_back(waypoint);
  }
  flight_path.length_m = root["length_m"].Number();
  flight_path.duration_s = root["duration_s"].Number();
  flight_path.min_clearance_m = root["min_clearance_m"].Number();
  for (const JsonNode& node : root["dropped_view_ids"].Items()) {
    flight_path.dropped_view_ids.push_back(node.Integer());
  }
  if (const auto reasons = root.Find("drop_reasons")) {
    for (const JsonNode& node : reasons->Items()) {
      flight_path.drop_reasons.push_back(node.Text());
    }
  }
  flight_path.flights = ReadFlights(root, flight_path.waypoints.size());
  return flight_path;
}

}  // namespace colmap_ext
