// Normals for clouds that come without.
#pragma once

#include <vector>

#include "colmap_ext/scene/oriented_points.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

// Sets the normal of every point: that of the plane through its `num_neighbors` (>= 3) nearest
// points, towards the nearest photo that has the point in its picture (occlusion is not known yet),
// or, where none has, towards the nearest photo of all. Parallel over points; same input, same
// normals. Throws Error for fewer points than neighbours, and without photos.
void EstimateNormals(const std::vector<PosedPhoto>& photos, int num_neighbors,
                     OrientedPoints* points);

}  // namespace colmap_ext
