#include "pictures.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/picture_overlay.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/util/text.h"
#include "measures.h"

namespace colmap_ext {
namespace {

constexpr int kYawsDeg[] = {30, 210};

// The judged surface, and for each vertex the judged point that stands for it.
struct JudgedSurface {
  JudgedSurface(const JudgedFlight& judged, const std::filesystem::path& surface)
      : painter(ReadMesh(surface)) {
    std::vector<Eigen::Vector3d> positions;
    for (const JudgedPoint& point : judged.points) {
      positions.push_back(point.point.position);
      bounds.extend(point.point.position);
    }
    const PointIndex index(positions);
    for (const Eigen::Vector3d& vertex : painter.mesh().vertices) {
      const auto nearest = index.Nearest(vertex, 2 * judged.spacing_m);
      point_of_vertex.push_back(nearest ? nearest->index : -1);
    }
  }

  cv::Mat Paint(const std::vector<Eigen::Vector3d>& color_of_point, int yaw_deg,
                const cv::Size& size) const {
    std::vector<Eigen::Vector3d> colors;
    for (const int point : point_of_vertex) {
      colors.push_back(point < 0 ? Eigen::Vector3d::Constant(0.75)
                                 : color_of_point[static_cast<std::size_t>(point)]);
    }
    const PictureCamera camera = FitCamera(bounds, {DegToRad(yaw_deg), DegToRad(-25)}, size);
    return painter.Render(VertexColors(painter.mesh(), colors), camera).bgr;
  }

  MeshPainter painter;
  BoundingBox bounds;
  std::vector<int> point_of_vertex;  // -1: none near
};

Eigen::Vector3d VerdictColor(const JudgedPoint& judged, double bad_m) {
  const bool is_flagged = judged.point.coverage == CoverageClass::kUncovered;
  const bool is_bad = judged.true_error_m > bad_m;
  if (is_flagged) return is_bad ? Eigen::Vector3d(0.8, 0.2, 0.15) : Eigen::Vector3d(0.95, 0.8, 0.2);
  return is_bad ? Eigen::Vector3d(0.15, 0.3, 0.85) : Eigen::Vector3d(0.4, 0.75, 0.5);
}

// One colour a point: orange for the `count` points of most doubt.
std::vector<Eigen::Vector3d> ColorsOfWorst(const std::vector<double>& doubt, std::size_t count) {
  std::vector<std::size_t> order(doubt.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return doubt[a] > doubt[b]; });
  std::vector<Eigen::Vector3d> colors(doubt.size(), Eigen::Vector3d(0.45, 0.68, 0.86));
  for (std::size_t i = 0; i < count; ++i) colors[order[i]] = {0.84, 0.37, 0.05};
  return colors;
}

}  // namespace

void PaintVerdicts(const JudgedFlight& judged, const std::filesystem::path& surface, double bad_m,
                   const std::filesystem::path& stem) {
  const JudgedSurface painted(judged, surface);
  std::vector<Eigen::Vector3d> colors;
  for (const JudgedPoint& point : judged.points) colors.push_back(VerdictColor(point, bad_m));
  for (const int yaw_deg : kYawsDeg) {
    WritePng(painted.Paint(colors, yaw_deg, {1400, 1000}),
             stem.string() + "_" + std::to_string(yaw_deg) + ".png");
  }
}

void PaintComparison(const JudgedFlight& judged, const std::filesystem::path& surface, double bad_m,
                     const std::filesystem::path& stem) {
  struct Rule {
    const char* caption;
    std::function<double(const JudgedPoint&)> doubt;
  };
  const Rule rules[] = {
      {"our score", [](const JudgedPoint& p) { return 1 - p.point.score; }},
      {"density and smoothness", [](const JudgedPoint& p) { return -p.cloud.ScannerConfidence(); }},
      {"truth: error", [](const JudgedPoint& p) { return p.true_error_m; }}};
  std::vector<bool> is_bad;
  for (const JudgedPoint& point : judged.points) is_bad.push_back(point.true_error_m > bad_m);
  const auto num_bad = static_cast<std::size_t>(std::count(is_bad.begin(), is_bad.end(), true));

  const JudgedSurface painted(judged, surface);
  const cv::Size tile(860, 680);
  for (const int yaw_deg : kYawsDeg) {
    cv::Mat sheet(tile.height, 3 * tile.width, CV_8UC3);
    int column = 0;
    for (const Rule& rule : rules) {
      std::vector<double> doubt;
      for (const JudgedPoint& point : judged.points) doubt.push_back(rule.doubt(point));
      cv::Mat picture = painted.Paint(ColorsOfWorst(doubt, num_bad), yaw_deg, tile);
      std::string caption = rule.caption;
      caption += column < 2 ? FormatNumber(", AUC %.2f", AreaUnderCurve(doubt, is_bad))
                            : FormatNumber(" above %.0f mm", 1000 * bad_m);
      DrawText(caption, {20, 30}, 18, {0.1f, 0.1f, 0.12f}, TextAnchor::kLeft, 3, &picture);
      picture.copyTo(sheet({column++ * tile.width, 0, tile.width, tile.height}));
    }
    WritePng(sheet, stem.string() + "_rules_" + std::to_string(yaw_deg) + ".png");
  }
}

}  // namespace colmap_ext
