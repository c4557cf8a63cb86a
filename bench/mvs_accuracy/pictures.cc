#include "pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/mvs/depth_map.h"

namespace colmap_ext {
namespace {

cv::Vec3b GreyOf(float depth, float nearest) {
  if (!(depth > 0)) return {90, 0, 0};
  const auto level = cv::saturate_cast<std::uint8_t>(255.0F * nearest / depth);
  return {level, level, level};
}

cv::Vec3b Judgement(float depth, float confidence, float truth) {
  if (!(depth > 0)) return {0, 0, 0};
  if (!(confidence > 0.5F)) return {cv::saturate_cast<std::uint8_t>(60 + 390 * confidence), 40, 40};
  if (!(truth > 0)) return {0, 160, 255};
  const float error = std::abs(depth - truth) / truth;
  return error <= 0.02F ? cv::Vec3b(0, 200, 0) : cv::Vec3b(0, 0, 255);
}

cv::Mat MakePicture(const cv::Mat& bgr, const ViewMesh& view, const ViewTruth& truth) {
  const int width = bgr.cols, height = bgr.rows;
  const ViewMaps maps = RasterizeView(view, 0.0);
  float nearest = 1e9F;
  for (const float z : truth.depth) nearest = z > 0 ? std::min(nearest, z) : nearest;
  cv::Mat3b out(2 * height, 2 * width);
  bgr.copyTo(out(cv::Rect(0, 0, width, height)));
  for (const Eigen::Vector3i& triangle : view.image.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d& a = view.image.vertices_px[static_cast<std::size_t>(triangle[k])];
      const Eigen::Vector2d& b =
          view.image.vertices_px[static_cast<std::size_t>(triangle[(k + 1) % 3])];
      cv::line(out, cv::Point2d(a.x() - 0.5, a.y() - 0.5), cv::Point2d(b.x() - 0.5, b.y() - 0.5),
               cv::Scalar(0, 255, 255), 1, cv::LINE_AA);
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float z = truth.depth(y, x), depth = maps.depth.At(y, x);
      out(y, width + x) = GreyOf(z, nearest);
      out(height + y, x) = Judgement(depth, maps.confidence.At(y, x), z);
      out(height + y, width + x) = GreyOf(depth, nearest);
    }
  }
  return out;
}

}  // namespace

void WriteErrorPictures(const Survey& survey, const std::vector<ViewMesh>& views, int every,
                        const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < views.size(); i += static_cast<std::size_t>(std::max(1, every))) {
    const PosedPhoto& photo = survey.photos.photos[i];
    cv::imwrite((folder / (photo.name + ".png")).string(),
                MakePicture(photo.bgr, views[i], survey.truth[i]));
  }
}

}  // namespace colmap_ext
