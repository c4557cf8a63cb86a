#include <nlohmann/json.hpp>

#include "colmap_ext/mission/export_formats.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

double Height(const Mission& mission, const MissionStop& stop) {
  return stop.height.ellipsoidal_m.value_or(mission.frame_height_m + stop.height.relative_m);
}

Json Coordinates(const Mission& mission, const MissionStop& stop) {
  return Json::array({stop.lon_deg, stop.lat_deg, Height(mission, stop)});
}

Json ViewFeature(const Mission& mission, const MissionStop& stop) {
  Json properties = {{"view_id", stop.view_id},
                     {"yaw_deg", RadToDeg(stop.direction.yaw_rad)},
                     {"pitch_deg", RadToDeg(stop.direction.pitch_rad)},
                     {"height_m", Height(mission, stop)},
                     {"relative_height_m", stop.height.relative_m}};
  if (stop.height.amsl_m) properties["amsl_m"] = *stop.height.amsl_m;
  return {{"type", "Feature"},
          {"geometry", {{"type", "Point"}, {"coordinates", Coordinates(mission, stop)}}},
          {"properties", properties}};
}

// A LineString must have two positions: a path of one stop becomes a Point.
Json PathFeature(const Mission& mission) {
  Json line = Json::array();
  for (const MissionStop& stop : mission.stops) line.push_back(Coordinates(mission, stop));
  Json geometry = {{"type", "LineString"}, {"coordinates", line}};
  if (line.size() == 1) geometry = {{"type", "Point"}, {"coordinates", line[0]}};
  const bool is_ellipsoidal = mission.home.height.ellipsoidal_m.has_value();
  return {{"type", "Feature"},
          {"geometry", geometry},
          {"properties",
           {{"name", "path"},
            {"length_m", mission.length_m},
            {"duration_s", mission.duration_s},
            {"height_datum", is_ellipsoidal ? "ellipsoidal" : "as the model's"}}}};
}

}  // namespace

std::string GeoJson(const Mission& mission) {
  Json features = Json::array({PathFeature(mission)});
  for (const MissionStop& stop : mission.stops) {
    if (stop.view_id >= 0) features.push_back(ViewFeature(mission, stop));
  }
  return Json{{"type", "FeatureCollection"}, {"features", features}}.dump(2) + "\n";
}

}  // namespace colmap_ext
