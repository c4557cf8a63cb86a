#include "colmap_ext/scene/world_frame.h"

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/region_json.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

Json ToJson(const Eigen::Vector3d& vector) {
  return Json::array({vector.x(), vector.y(), vector.z()});
}

}  // namespace

bool RegionOfInterest::Contains(const Eigen::Vector3d& point_in_world) const {
  if (!box.contains(point_in_world)) return false;
  return rings.empty() || IsInsideRings(rings, point_in_world.head<2>());
}

Json RegionToJson(const RegionOfInterest& region) {
  Json json = {{"min_enu_m", ToJson(region.box.min())}, {"max_enu_m", ToJson(region.box.max())}};
  for (const PolygonRing& ring : region.rings) {
    Json corners = Json::array();
    for (const Eigen::Vector2d& corner : ring) {
      corners.push_back(Json::array({corner.x(), corner.y()}));
    }
    json["rings_enu_m"].push_back(std::move(corners));
  }
  return json;
}

RegionOfInterest RegionFromJson(const JsonNode& node) {
  RegionOfInterest region{BoundingBox(node["min_enu_m"].Vector(), node["max_enu_m"].Vector())};
  if (const auto rings = node.Find("rings_enu_m")) {
    for (const JsonNode& ring : rings->Items()) {
      region.rings.emplace_back();
      for (const JsonNode& corner : ring.Items()) {
        const std::vector<JsonNode> xy = corner.Items();
        if (xy.size() != 2) corner.Fail("must be [x, y]");
        region.rings.back().emplace_back(xy[0].Number(), xy[1].Number());
      }
      if (region.rings.back().size() < 3) ring.Fail("must have at least 3 corners");
    }
  }
  return region;
}

WorldFrame ReadWorldFrame(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  WorldFrame frame;
  frame.is_metric_enu = root["metric"].Boolean();
  if (const auto origin = root.Find("origin")) {
    frame.origin = GeoPosition{.lat_deg = (*origin)["lat"].Number(),
                               .lon_deg = (*origin)["lon"].Number(),
                               .height_m = (*origin)["height_m"].Number()};
    if (!IsValid(*frame.origin)) origin->Fail("latitude or longitude is out of range");
    if (!frame.is_metric_enu) root["metric"].Fail("a frame with an origin is metric");
  }
  return frame;
}

void WriteWorldFrame(const WorldFrame& frame, const std::filesystem::path& path) {
  Json json;
  json["metric"] = frame.is_metric_enu;
  if (frame.origin) {
    if (!IsValid(*frame.origin) || !frame.is_metric_enu) {
      throw Error(path.string() + ": the origin of the world frame is invalid");
    }
    json["origin"] = {{"lat", frame.origin->lat_deg},
                      {"lon", frame.origin->lon_deg},
                      {"height_m", frame.origin->height_m}};
  }
  WriteJsonFile(json, path);
}

}  // namespace colmap_ext
