#include "colmap_ext/mission/geojson.h"

#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

Json Coordinates(const GeoPosition& origin, const Eigen::Vector3d& position) {
  const GeoPosition place = GeoFromEnu(origin, position);
  return Json::array({place.lon_deg, place.lat_deg, place.height_m});
}

Json ViewFeature(const GeoPosition& origin, const Waypoint& waypoint) {
  const Json coordinates = Coordinates(origin, waypoint.position);
  return {{"type", "Feature"},
          {"geometry", {{"type", "Point"}, {"coordinates", coordinates}}},
          {"properties",
           {{"view_id", waypoint.view_id},
            {"yaw_deg", RadToDeg(waypoint.direction.yaw_rad)},
            {"pitch_deg", RadToDeg(waypoint.direction.pitch_rad)},
            {"height_m", coordinates[2]}}}};
}

// A LineString must have two positions: a path of one waypoint becomes a Point.
Json PathFeature(const GeoPosition& origin, const FlightPath& path) {
  Json line = Json::array();
  for (const Waypoint& waypoint : path.waypoints) {
    line.push_back(Coordinates(origin, waypoint.position));
  }
  Json geometry = {{"type", "LineString"}, {"coordinates", line}};
  if (line.size() == 1) geometry = {{"type", "Point"}, {"coordinates", line[0]}};
  return {{"type", "Feature"},
          {"geometry", geometry},
          {"properties",
           {{"name", "path"}, {"length_m", path.length_m}, {"duration_s", path.duration_s}}}};
}

}  // namespace

std::string GeoJson(const FlightPath& path, const WorldFrame& frame) {
  if (!frame.origin.has_value()) {
    throw Error("GeoJSON: the model has no place on Earth (no GPS); export --format json");
  }
  if (path.waypoints.empty()) throw Error("GeoJSON: the path has no waypoints");
  Json features = Json::array({PathFeature(*frame.origin, path)});
  for (const Waypoint& waypoint : path.waypoints) {
    if (waypoint.view_id >= 0) features.push_back(ViewFeature(*frame.origin, waypoint));
  }
  return Json{{"type", "FeatureCollection"}, {"features", features}}.dump(2) + "\n";
}

}  // namespace colmap_ext
