#include "colmap_ext/mvs/depth_map.h"

#include "colmap_ext/mvs/view_lookup.h"

namespace colmap_ext {

ViewMaps RasterizeView(const ViewMesh& mesh, double min_confidence) {
  const int width = mesh.camera.width;
  const int height = mesh.camera.height;
  const ViewLookup lookup(mesh, TriangleIdMap(mesh));
  ViewMaps maps{{width, height, 1}, {width, height, 3}, {width, height, 1}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int id = lookup.triangle_at(y, x);
      if (id < 0) continue;
      const auto t = static_cast<std::size_t>(id);
      maps.confidence.At(y, x) = mesh.confidence[t];
      const double inverse_depth = lookup.InverseDepth(id, {x + 0.5, y + 0.5});
      if (mesh.supported[t] == 0 || mesh.confidence[t] < min_confidence || !(inverse_depth > 0)) {
        continue;
      }
      maps.depth.At(y, x) = static_cast<float>(1.0 / inverse_depth);
      const Eigen::Vector3d normal_in_cam = -lookup.plane_in_cam[t].normalized();
      for (int c = 0; c < 3; ++c) maps.normal.At(y, x, c) = static_cast<float>(normal_in_cam[c]);
    }
  }
  return maps;
}

}  // namespace colmap_ext
