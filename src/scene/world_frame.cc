#include "colmap_ext/scene/world_frame.h"

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {

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
