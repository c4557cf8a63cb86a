// The fused cloud as a PLY file.
#pragma once

#include <filesystem>

#include "colmap_ext/scene/oriented_points.h"

namespace colmap_ext {

// Properties x y z nx ny nz (float64, or float32 in files of others), red green blue (uchar),
// confidence (float), photo_index (int). The last five may be missing, as in COLMAP's fused.ply:
// then the defaults of OrientedPoint stand. Throws Error naming the file, and the point or
// property.
OrientedPoints ReadOrientedPoints(const std::filesystem::path& path);

// Comes back exactly. Throws Error naming a point that is not finite; nothing is written then.
void WriteOrientedPoints(const OrientedPoints& points, const std::filesystem::path& path);

}  // namespace colmap_ext
