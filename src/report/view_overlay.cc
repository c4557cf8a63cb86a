#include "colmap_ext/report/view_overlay.h"

#include <cmath>
#include <ostream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "report/packed_array.h"

namespace colmap_ext {
namespace {

constexpr double kStepsPerPixel = 16;

Json OverlayOf(const ViewMesh& view, const std::string& name) {
  const std::size_t count = view.image.triangles.size();
  if (view.confidence.size() != count || view.supported.size() != count ||
      view.image.superpixel.size() != count) {
    throw Error("page: the mesh of " + name + " has " + std::to_string(count) +
                " triangles but another number of confidences");
  }
  std::vector<std::int32_t> vertices, triangles, confidence;
  for (const Eigen::Vector2d& vertex : view.image.vertices_px) {
    for (int k = 0; k < 2; ++k) {
      vertices.push_back(static_cast<std::int32_t>(std::lround(vertex[k] * kStepsPerPixel)));
    }
  }
  for (const Eigen::Vector3i& triangle : view.image.triangles) {
    for (int k = 0; k < 3; ++k) triangles.push_back(triangle[k]);
  }
  for (std::size_t t = 0; t < count; ++t) {
    const bool is_supported = view.supported[t] != 0;
    confidence.push_back(
        is_supported ? static_cast<std::int32_t>(std::lround(100 * view.confidence[t])) : -1);
  }
  return {{"width", view.camera.width},
          {"height", view.camera.height},
          {"steps_per_pixel", kStepsPerPixel},
          {"vertices", PackIntegers(vertices, 2)},
          {"triangles", PackIntegers(triangles, 3)},
          {"superpixel", PackIntegers(view.image.superpixel, 1)},
          {"confidence", PackIntegers(confidence, 1)}};
}

}  // namespace

void WriteViewOverlays(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                       const std::filesystem::path& path) {
  if (views.size() != photos.photos.size()) {
    throw Error("page: " + std::to_string(views.size()) + " meshes for " +
                std::to_string(photos.photos.size()) + " photos");
  }
  std::vector<std::string> text(views.size());
  ParallelFor(views.size(),
              [&](std::size_t i) { text[i] = OverlayOf(views[i], photos.photos[i].name).dump(); });
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "{";
    for (std::size_t i = 0; i < views.size(); ++i) {
      out << (i == 0 ? "\n" : ",\n") << Json(photos.photos[i].name).dump() << ": " << text[i];
    }
    out << "\n}\n";
  });
}

}  // namespace colmap_ext
