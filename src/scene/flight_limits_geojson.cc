#include <optional>

#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/geojson_rings.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {
namespace {

// nullopt: the file's coordinates are metres of the world already.
using Origin = std::optional<GeoPosition>;

FlightZone::Kind KindOf(const JsonNode& fence) {
  const std::string kind = fence.Text();
  if (kind == "inclusion") return FlightZone::Kind::kInclusion;
  if (kind == "exclusion") return FlightZone::Kind::kExclusion;
  fence.Fail("must be \"inclusion\" or \"exclusion\"");
}

// What the properties say of a feature's zones.
FlightZone ZoneWithoutRings(const JsonNode& properties) {
  FlightZone zone;
  if (const auto fence = properties.Find("fence")) zone.kind = KindOf(*fence);
  if (const auto name = properties.Find("name")) zone.name = name->Text();
  if (const auto lowest = properties.Find("min_altitude_m")) zone.min_z_m = lowest->Number();
  if (const auto highest = properties.Find("max_altitude_m")) zone.max_z_m = highest->Number();
  if (!(zone.min_z_m < zone.max_z_m)) {
    properties.Fail("min_altitude_m must be below max_altitude_m");
  }
  return zone;
}

void AddGeometry(const JsonNode& geometry, const FlightZone& like, const Origin& origin,
                 std::vector<FlightZone>* zones) {
  const std::string type = geometry["type"].Text();
  std::vector<JsonNode> polygons;
  if (type == "Polygon") {
    polygons.push_back(geometry["coordinates"]);
  } else if (type == "MultiPolygon") {
    polygons = geometry["coordinates"].Items();
  } else {
    geometry["type"].Fail("is '" + type + "', but zones are Polygon or MultiPolygon");
  }
  for (const JsonNode& polygon : polygons) {
    FlightZone zone = like;
    zone.rings = ReadGeoJsonRings(polygon, origin);
    zones->push_back(std::move(zone));
  }
}

void AddObject(const JsonNode& object, const Origin& origin, std::vector<FlightZone>* zones) {
  const std::string type = object["type"].Text();
  if (type == "FeatureCollection") {
    for (const JsonNode& feature : object["features"].Items()) AddObject(feature, origin, zones);
  } else if (type == "Feature") {
    const auto properties = object.Find("properties");
    const bool has_properties = properties && !properties->IsNull();
    AddGeometry(object["geometry"], has_properties ? ZoneWithoutRings(*properties) : FlightZone(),
                origin, zones);
  } else {
    AddGeometry(object, FlightZone(), origin, zones);
  }
}

}  // namespace

FlightLimits ReadFlightLimits(const std::filesystem::path& geojson_path, const WorldFrame& frame) {
  const Json json = ReadJsonFile(geojson_path);
  const JsonNode root(json, geojson_path);
  Origin origin = frame.origin;
  const auto frame_of_file = root.Find("frame");
  if (frame_of_file) {
    if (frame_of_file->Text() != "enu_m") frame_of_file->Fail("must be \"enu_m\" or absent");
    origin.reset();
  } else if (!origin) {
    root.Fail(
        "has longitudes and latitudes, but the model has no origin on Earth; give x, y in "
        "metres of the world, with \"frame\": \"enu_m\"");
  }
  FlightLimits limits;
  AddObject(root, origin, &limits.zones);
  if (limits.zones.empty()) root.Fail("has no polygon");
  return limits;
}

}  // namespace colmap_ext
