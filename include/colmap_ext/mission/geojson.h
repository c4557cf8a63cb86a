#pragma once

#include <string>

#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

// GeoJSON (RFC 7946) text of a path: one LineString "path", and a Point for each photographed view
// with its id, yaw_deg, pitch_deg and height_m. Coordinates are [longitude, latitude, height] with
// the height in the frame's datum (GeoJSON means it to be above the ellipsoid). Throws Error when
// the frame has no origin on Earth or the path has no waypoints.
std::string GeoJson(const FlightPath& path, const WorldFrame& frame);

}  // namespace colmap_ext
