#include "pictures.h"

#include <opencv2/imgproc.hpp>

#include "colmap_ext/eval/error_colors.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/picture_overlay.h"

namespace colmap_ext {
namespace {

const cv::Size kTile(560, 460);

// What lies near the truth: a model's ground and far scraps would hide it.
TriangleMesh NearTheTruth(const TriangleMesh& mesh, const BoundingBox& bounds) {
  BoundingBox room = bounds;
  room.extend(bounds.min() - Eigen::Vector3d(0.5, 0.5, 0.1));
  room.extend(bounds.max() + Eigen::Vector3d::Constant(0.5));
  TriangleMesh near = mesh;
  std::erase_if(near.faces, [&](const auto& face) {
    for (const int corner : face) {
      if (!room.contains(mesh.vertices[static_cast<std::size_t>(corner)])) return true;
    }
    return false;
  });
  return near;
}

}  // namespace

void PaintSideBySide(const TriangleMesh& truth, const std::vector<ModelToPaint>& models,
                     double error_limit_m, int columns, const std::filesystem::path& png) {
  const BoundingBox bounds = BoundsOf(truth);
  const PictureCamera camera = FitCamera(bounds, {DegToRad(30), DegToRad(-25)}, kTile);
  const MeshPainter truth_painter(truth);
  const int rows = (static_cast<int>(models.size()) + columns - 1) / columns;
  cv::Mat sheet(2 * rows * kTile.height, columns * kTile.width, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 0; i < models.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const MeshPainter painter(NearTheTruth(models[i].mesh, bounds));
    cv::Mat shape = painter.Render(ConstantColor({0.80f, 0.80f, 0.78f}), camera).bgr;
    const auto colors = ErrorColors(DistancesTo(models[i].mesh, truth.vertices), error_limit_m);
    const cv::Mat error =
        truth_painter.Render(VertexColors(truth_painter.mesh(), colors), camera).bgr;
    DrawText(models[i].caption, {14, 20}, 13, {0.1f, 0.1f, 0.12f}, TextAnchor::kLeft, 3, &shape);
    shape.copyTo(sheet({column * kTile.width, 2 * row * kTile.height, kTile.width, kTile.height}));
    error.copyTo(
        sheet({column * kTile.width, (2 * row + 1) * kTile.height, kTile.width, kTile.height}));
  }
  WritePng(sheet, png);
}

}  // namespace colmap_ext
