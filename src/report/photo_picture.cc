#include "colmap_ext/report/photo_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/report/picture_overlay.h"
#include "colmap_ext/util/error.h"
#include "report/blend.h"

namespace colmap_ext {
namespace {

constexpr int kShift = 4;  // fixed-point bits of cv drawing

// Dark violet to yellow, rising in lightness, so that it reads in grey and without red and green.
Rgb ConfidenceColor(double confidence) {
  static const std::array<Rgb, 5> kStops = {Rgb(0.27f, 0.00f, 0.33f), Rgb(0.23f, 0.32f, 0.55f),
                                            Rgb(0.13f, 0.57f, 0.55f), Rgb(0.37f, 0.79f, 0.38f),
                                            Rgb(0.99f, 0.91f, 0.14f)};
  const double position = std::clamp(confidence, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(position), kStops.size() - 2);
  const auto share = static_cast<float>(position - static_cast<double>(below));
  return (1 - share) * kStops[below] + share * kStops[below + 1];
}

cv::Mat Enlarged(const cv::Mat& bgr, int width_px) {
  if (bgr.empty() || bgr.type() != CV_8UC3) throw Error("picture: the photo has no colour pixels");
  if (width_px < 16) throw Error("picture: the width must be 16 px or more");
  const double scale = static_cast<double>(width_px) / bgr.cols;
  cv::Mat large;
  cv::resize(bgr, large, {width_px, static_cast<int>(std::lround(bgr.rows * scale))}, 0, 0,
             scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return large;
}

// Fixed-point position for cv drawing (whose origin is the centre of the first pixel).
cv::Point ToFixed(const Eigen::Vector2d& pixel, double scale) {
  const Eigen::Vector2d position = (pixel * scale).array() - 0.5;
  return {static_cast<int>(std::lround(position.x() * (1 << kShift))),
          static_cast<int>(std::lround(position.y() * (1 << kShift)))};
}

const Eigen::Vector2d& CornerOf(const ImageMesh& mesh, std::size_t t, int k) {
  return mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][k])];
}

}  // namespace

cv::Mat DrawSuperpixels(const cv::Mat& bgr, const ImageMesh& mesh, int width_px) {
  cv::Mat picture = Enlarged(bgr, width_px);
  const double scale = static_cast<double>(width_px) / bgr.cols;
  cv::Mat inner(picture.size(), CV_8U, cv::Scalar(0)), outline = inner.clone();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int neighbor = mesh.neighbors[t][k];
      if (neighbor >= 0 && neighbor < static_cast<int>(t)) continue;  // drawn from the other side
      const bool is_inner = neighbor >= 0 && mesh.superpixel[static_cast<std::size_t>(neighbor)] ==
                                                 mesh.superpixel[t];
      cv::line(is_inner ? inner : outline, ToFixed(CornerOf(mesh, t, (k + 1) % 3), scale),
               ToFixed(CornerOf(mesh, t, (k + 2) % 3), scale), cv::Scalar(255), 1, cv::LINE_AA,
               kShift);
    }
  }
  cv::Mat mask;
  inner.convertTo(mask, CV_32F, 1.0 / 255);
  BlendColor(mask, {1, 1, 1}, 0.22, &picture);
  outline.convertTo(mask, CV_32F, 1.0 / 255);
  BlendColor(mask, {1.0f, 0.86f, 0.25f}, 0.9, &picture);
  return picture;
}

cv::Mat DrawConfidence(const cv::Mat& bgr, const ViewMesh& mesh, int width_px) {
  cv::Mat picture = Enlarged(bgr, width_px);
  const std::size_t count = mesh.image.triangles.size();
  if (mesh.confidence.size() != count || mesh.supported.size() != count) {
    throw Error("picture: the mesh has " + std::to_string(count) + " triangles but " +
                std::to_string(mesh.confidence.size()) + " confidences");
  }
  const double scale = static_cast<double>(width_px) / bgr.cols;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  picture.convertTo(picture, -1, 0.75, 50);
  cv::Mat colored = picture.clone();
  for (std::size_t t = 0; t < count; ++t) {
    if (mesh.supported[t] == 0) continue;
    const std::array<cv::Point, 3> corners = {ToFixed(CornerOf(mesh.image, t, 0), scale),
                                              ToFixed(CornerOf(mesh.image, t, 1), scale),
                                              ToFixed(CornerOf(mesh.image, t, 2), scale)};
    const Rgb color = 255.0f * ConfidenceColor(mesh.confidence[t]);
    cv::fillConvexPoly(colored, corners.data(), 3, cv::Scalar(color[2], color[1], color[0]),
                       cv::LINE_AA, kShift);
  }
  cv::addWeighted(colored, 0.72, picture, 0.28, 0, picture);
  std::vector<LegendRow> rows;
  for (const double level : {1.0, 0.75, 0.5, 0.25, 0.0}) {
    char label[8];
    std::snprintf(label, sizeof label, "%.2f", level);
    rows.push_back({ConfidenceColor(level), label, "", false});
  }
  rows.push_back({{0.7f, 0.7f, 0.7f}, "no support", "", false});
  DrawLegend("Confidence", rows, &picture);
  return picture;
}

}  // namespace colmap_ext
