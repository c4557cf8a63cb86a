#include "sim/texture.h"

#include <opencv2/imgproc.hpp>

#include "sim/noise.h"

namespace colmap_ext {
namespace {

Eigen::Vector3f Texel(const cv::Mat& level, int x, int y) {
  const unsigned char* t = level.ptr<unsigned char>(y) + 4 * x;
  return {static_cast<float>(t[0]), static_cast<float>(t[1]), static_cast<float>(t[2])};
}

}  // namespace

MipTexture::MipTexture(const cv::Mat& bgr) {
  cv::Mat level;
  cv::cvtColor(bgr, level, cv::COLOR_BGR2BGRA);
  levels_.push_back(level);
  while (level.cols > 1 || level.rows > 1) {
    cv::Mat half;
    const cv::Size size(std::max(1, level.cols / 2), std::max(1, level.rows / 2));
    cv::resize(level, half, size, 0, 0, cv::INTER_AREA);
    levels_.push_back(half);
    level = half;
  }
}

Eigen::Vector3f MipTexture::Sample(float u, float v, int level) const {
  const cv::Mat& image = levels_[static_cast<std::size_t>(std::clamp(level, 0, NumLevels() - 1))];
  u -= static_cast<float>(FloorInt(u));
  v -= static_cast<float>(FloorInt(v));
  // Texel centres at half integers.
  const float x = u * static_cast<float>(image.cols) - 0.5F;
  const float y = (1 - v) * static_cast<float>(image.rows) - 0.5F;
  int x0 = FloorInt(x), y0 = FloorInt(y);
  const float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
  int x1 = x0 + 1, y1 = y0 + 1;
  if (x0 < 0) x0 = image.cols - 1;
  if (x1 >= image.cols) x1 = 0;
  if (y0 < 0) y0 = image.rows - 1;
  if (y1 >= image.rows) y1 = 0;
  if (y0 >= image.rows) y0 = 0;
  const Eigen::Vector3f top = Texel(image, x0, y0) * (1 - tx) + Texel(image, x1, y0) * tx;
  const Eigen::Vector3f bottom = Texel(image, x0, y1) * (1 - tx) + Texel(image, x1, y1) * tx;
  return top * (1 - ty) + bottom * ty;
}

}  // namespace colmap_ext
