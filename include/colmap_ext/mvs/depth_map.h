#pragma once

#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// A view's mesh pixel by pixel, at pixel centres.
struct ViewMaps {
  DenseMap depth;       // 1 channel: z in the camera frame; 0 where there is none
  DenseMap normal;      // 3 channels: unit, camera frame, facing the camera; 0 where there is none
  DenseMap confidence;  // 1 channel: Γ, 0 … 1, wherever a triangle is
};

// Supported triangles with confidence >= min_confidence. Inverse depth is affine in the pixel, so
// the interpolation inside a triangle is exact.
ViewMaps RasterizeView(const ViewMesh& mesh, double min_confidence);

}  // namespace colmap_ext
