#include "colmap_ext/mvs/draw.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "colmap_ext/mvs/view_lookup.h"

namespace colmap_ext {
namespace {

constexpr double kOverlayScale = 2.0;
const cv::Vec3b kUnsupported(90, 30, 20);

// Fixed-point position of an edge's end, as cv::line wants it.
cv::Point ToFixedPoint(const Eigen::Vector2d& p, int shift) {
  const double unit = kOverlayScale * (1 << shift);
  // OpenCV's pixel centres are whole numbers.
  const double half = 0.5 * (1 << shift);
  return {static_cast<int>(p.x() * unit - half), static_cast<int>(p.y() * unit - half)};
}

}  // namespace

cv::Mat DrawSuperpixelOverlay(const cv::Mat& bgr, const ImageMesh& mesh) {
  constexpr int kShift = 4;
  const cv::Scalar polygon_color(0, 230, 255);
  const cv::Scalar triangle_color(150, 150, 150);
  cv::Mat picture;
  cv::resize(bgr, picture, {}, kOverlayScale, kOverlayScale, cv::INTER_CUBIC);
  for (const bool draws_polygons : {false, true}) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const int other = mesh.neighbors[t][k];
        if (other < static_cast<int>(t)) continue;
        const bool is_polygon_edge =
            mesh.superpixel[static_cast<std::size_t>(other)] != mesh.superpixel[t];
        if (is_polygon_edge != draws_polygons) continue;
        const auto a = static_cast<std::size_t>(mesh.triangles[t][(k + 1) % 3]);
        const auto b = static_cast<std::size_t>(mesh.triangles[t][(k + 2) % 3]);
        cv::line(picture, ToFixedPoint(mesh.vertices_px[a], kShift),
                 ToFixedPoint(mesh.vertices_px[b], kShift),
                 draws_polygons ? polygon_color : triangle_color, 1, cv::LINE_AA, kShift);
      }
    }
  }
  return picture;
}

cv::Mat DrawConfidence(const cv::Mat& bgr, const ViewMesh& mesh) {
  const cv::Mat1i ids = TriangleIdMap(mesh);
  cv::Mat gray;
  if (!bgr.empty()) cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::Mat3b picture(ids.size(), kUnsupported);
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      const int t = ids(y, x);
      if (t < 0 || mesh.supported[static_cast<std::size_t>(t)] == 0) continue;
      const double confidence = mesh.confidence[static_cast<std::size_t>(t)];
      const double light = gray.empty() ? 1.0 : 0.35 + 0.65 * gray.at<std::uint8_t>(y, x) / 255.0;
      const double red = std::min(1.0, 2.0 - 2.0 * confidence);
      const double green = std::min(1.0, 2.0 * confidence);
      picture(y, x) = cv::Vec3b(cv::saturate_cast<std::uint8_t>(25 * light),
                                cv::saturate_cast<std::uint8_t>(230 * light * green),
                                cv::saturate_cast<std::uint8_t>(230 * light * red));
    }
  }
  return picture;
}

cv::Mat DrawDepth(const ViewMesh& mesh) {
  const ViewLookup lookup(mesh, TriangleIdMap(mesh));
  const cv::Mat1i& ids = lookup.triangle_at;
  cv::Mat1d inverse_depth(ids.size(), 0.0);
  std::vector<double> values;
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      const int t = ids(y, x);
      if (t < 0 || mesh.supported[static_cast<std::size_t>(t)] == 0) continue;
      inverse_depth(y, x) = std::max(0.0, lookup.InverseDepth(t, {x + 0.5, y + 0.5}));
      values.push_back(inverse_depth(y, x));
    }
  }
  cv::Mat3b picture(ids.size(), kUnsupported);
  if (values.empty()) return picture;
  std::sort(values.begin(), values.end());
  const double low = values[values.size() / 50];
  const double high = std::max(values[values.size() - 1 - values.size() / 50], low + 1e-12);
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      if (inverse_depth(y, x) <= 0) continue;
      const double brightness = (inverse_depth(y, x) - low) / (high - low);
      picture(y, x) = cv::Vec3b::all(cv::saturate_cast<std::uint8_t>(30 + 225 * brightness));
    }
  }
  return picture;
}

}  // namespace colmap_ext
