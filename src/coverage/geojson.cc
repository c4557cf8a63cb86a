#include "colmap_ext/coverage/region.h"
#include "colmap_ext/scene/geojson_rings.h"

namespace colmap_ext {
namespace {

void AddPolygon(const JsonNode& polygon, const WorldFrame& frame, std::vector<PolygonRing>* rings) {
  for (PolygonRing& ring : ReadGeoJsonRings(polygon, frame.origin))
    rings->push_back(std::move(ring));
}

// Geometries of other types (a point where the pilot stands) are none of ours.
void AddGeometry(const JsonNode& node, const WorldFrame& frame, std::vector<PolygonRing>* rings) {
  const std::string type = node["type"].Text();
  if (type == "FeatureCollection") {
    for (const JsonNode& feature : node["features"].Items()) AddGeometry(feature, frame, rings);
  } else if (type == "Feature") {
    AddGeometry(node["geometry"], frame, rings);
  } else if (type == "GeometryCollection") {
    for (const JsonNode& member : node["geometries"].Items()) AddGeometry(member, frame, rings);
  } else if (type == "Polygon") {
    AddPolygon(node["coordinates"], frame, rings);
  } else if (type == "MultiPolygon") {
    for (const JsonNode& polygon : node["coordinates"].Items()) AddPolygon(polygon, frame, rings);
  }
}

}  // namespace

std::vector<PolygonRing> ReadPolygon(const std::filesystem::path& path, const WorldFrame& frame) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  std::vector<PolygonRing> rings;
  AddGeometry(root, frame, &rings);
  if (rings.empty()) root.Fail("holds no Polygon or MultiPolygon");
  return rings;
}

}  // namespace colmap_ext
