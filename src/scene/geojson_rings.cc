#include "colmap_ext/scene/geojson_rings.h"

#include <cmath>

namespace colmap_ext {
namespace {

Eigen::Vector2d ReadCorner(const JsonNode& node, const std::optional<GeoPosition>& origin) {
  constexpr double kFarthestM = 100e3;
  const std::vector<JsonNode> numbers = node.Items();
  if (numbers.size() < 2) node.Fail("must be [longitude, latitude]");
  const double first = numbers[0].Number(), second = numbers[1].Number();
  if (!origin) return {first, second};
  const GeoPosition position{.lat_deg = second, .lon_deg = first, .height_m = origin->height_m};
  if (!IsValid(position)) node.Fail("must be [longitude, latitude] in degrees");
  const Eigen::Vector2d corner = EnuFromGeo(*origin, position).head<2>();
  if (!(corner.norm() < kFarthestM)) {
    node.Fail(
        "lies more than 100 km from the origin of the model; longitude comes first, then latitude");
  }
  return corner;
}

PolygonRing ReadRing(const JsonNode& node, const std::optional<GeoPosition>& origin) {
  constexpr double kSamePlaceM = 1e-6;
  PolygonRing ring;
  for (const JsonNode& corner : node.Items()) ring.push_back(ReadCorner(corner, origin));
  if (ring.size() > 1 && (ring.front() - ring.back()).norm() < kSamePlaceM) ring.pop_back();
  if (ring.size() < 3 || !(std::abs(SignedArea(ring)) > 0)) {
    node.Fail("must be a ring of at least three corners with an area");
  }
  return ring;
}

}  // namespace

std::vector<PolygonRing> ReadGeoJsonRings(const JsonNode& coordinates,
                                          const std::optional<GeoPosition>& origin) {
  std::vector<PolygonRing> rings;
  for (const JsonNode& node : coordinates.Items()) rings.push_back(ReadRing(node, origin));
  if (rings.empty()) coordinates.Fail("must hold a ring");
  return rings;
}

}  // namespace colmap_ext
