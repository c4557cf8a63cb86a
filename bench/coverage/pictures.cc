#include "pictures.h"

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/scene/mesh_io.h"

namespace colmap_ext {
namespace {

Eigen::Vector3d VerdictColor(const JudgedPoint& judged, double bad_m) {
  const bool is_flagged = judged.point.coverage == CoverageClass::kUncovered;
  const bool is_bad = judged.true_error_m > bad_m;
  if (is_flagged) return is_bad ? Eigen::Vector3d(0.8, 0.2, 0.15) : Eigen::Vector3d(0.95, 0.8, 0.2);
  return is_bad ? Eigen::Vector3d(0.15, 0.3, 0.85) : Eigen::Vector3d(0.4, 0.75, 0.5);
}

}  // namespace

void PaintVerdicts(const JudgedFlight& judged, const std::filesystem::path& surface, double bad_m,
                   const std::filesystem::path& stem) {
  const TriangleMesh mesh = ReadMesh(surface);
  std::vector<Eigen::Vector3d> positions;
  BoundingBox bounds;
  for (const JudgedPoint& point : judged.points) {
    positions.push_back(point.point.position);
    bounds.extend(point.point.position);
  }
  const PointIndex index(positions);
  std::vector<Eigen::Vector3d> colors;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const auto nearest = index.Nearest(vertex, 2 * judged.spacing_m);
    colors.push_back(
        nearest ? VerdictColor(judged.points[static_cast<std::size_t>(nearest->index)], bad_m)
                : Eigen::Vector3d::Constant(0.75));
  }
  const MeshPainter painter(mesh);
  for (const int yaw_deg : {30, 210}) {
    const PictureCamera camera =
        FitCamera(bounds, {DegToRad(yaw_deg), DegToRad(-25)}, {1400, 1000});
    WritePng(painter.Render(VertexColors(painter.mesh(), colors), camera).bgr,
             stem.string() + "_" + std::to_string(yaw_deg) + ".png");
  }
}

}  // namespace colmap_ext
