#pragma once

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

// The region as JSON files keep it: {"min_enu_m": [x, y, z], "max_enu_m": [x, y, z], "rings_enu_m":
// [[[x, y], …], …] (only with rings)}. What is read is what was written, to the last bit. Errors
// name file and place.
Json RegionToJson(const RegionOfInterest& region);
RegionOfInterest RegionFromJson(const JsonNode& node);

}  // namespace colmap_ext
