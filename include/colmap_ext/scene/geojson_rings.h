#pragma once

#include <optional>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/polygon.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

// The rings of one GeoJSON polygon (RFC 7946, its "coordinates"), in metres of the world: from
// longitude and latitude in the ENU frame at `origin`, or, without one, numbers that are metres of
// the world already. A last corner that repeats the first is left out. Throws Error naming file and
// place: numbers that are no longitude and latitude, corners more than 100 km from the origin,
// rings of fewer than three corners or without an area, a polygon without a ring.
std::vector<PolygonRing> ReadGeoJsonRings(const JsonNode& coordinates,
                                          const std::optional<GeoPosition>& origin);

}  // namespace colmap_ext
