#include <cmath>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {
namespace {

Eigen::Vector2d Corner(const JsonNode& node, const WorldFrame& frame) {
  constexpr double kFarthestM = 100e3;
  const std::vector<JsonNode> numbers = node.Items();
  if (numbers.size() < 2) node.Fail("must be [longitude, latitude]");
  const double first = numbers[0].Number(), second = numbers[1].Number();
  if (!frame.origin) return {first, second};
  const GeoPosition position{
      .lat_deg = second, .lon_deg = first, .height_m = frame.origin->height_m};
  if (!IsValid(position)) node.Fail("must be [longitude, latitude] in degrees");
  const Eigen::Vector2d corner = EnuFromGeo(*frame.origin, position).head<2>();
  if (!(corner.norm() < kFarthestM)) {
    node.Fail("lies more than 100 km from the photos; longitude comes first, then latitude");
  }
  return corner;
}

double SignedArea(const PolygonRing& ring) {
  double twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

void AddPolygon(const JsonNode& polygon, const WorldFrame& frame, std::vector<PolygonRing>* rings) {
  for (const JsonNode& node : polygon.Items()) {
    PolygonRing ring;
    for (const JsonNode& corner : node.Items()) ring.push_back(Corner(corner, frame));
    if (ring.size() > 1 && (ring.front() - ring.back()).norm() < 1e-9) ring.pop_back();
    if (ring.size() < 3 || !(std::abs(SignedArea(ring)) > 0)) {
      node.Fail("must be a ring of at least three corners with an area");
    }
    rings->push_back(std::move(ring));
  }
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
