#include "report/blend.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {

void BlendColor(const cv::Mat& mask, const Rgb& color, double opacity, cv::Mat* bgr) {
  const cv::Vec3f target(color[2] * 255.0f, color[1] * 255.0f, color[0] * 255.0f);
  for (int y = 0; y < bgr->rows; ++y) {
    const auto* mask_row = mask.ptr<float>(y);
    auto* row = bgr->ptr<cv::Vec3b>(y);
    for (int x = 0; x < bgr->cols; ++x) {
      if (mask_row[x] <= 0) continue;
      const float share = mask_row[x] * static_cast<float>(opacity);
      for (int k = 0; k < 3; ++k) {
        const float mixed = (1 - share) * static_cast<float>(row[x][k]) + share * target[k];
        row[x][k] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0f, 255.0f)));
      }
    }
  }
}

cv::Mat RoundedRectangle(const cv::Size& size, const cv::Rect2d& rectangle, double corner_px) {
  cv::Mat mask(size, CV_32F, cv::Scalar(0));
  const double middle_x = rectangle.x + 0.5 * rectangle.width;
  const double middle_y = rectangle.y + 0.5 * rectangle.height;
  const int x_end = std::min(size.width, static_cast<int>(rectangle.x + rectangle.width) + 2);
  const int y_end = std::min(size.height, static_cast<int>(rectangle.y + rectangle.height) + 2);
  for (int y = std::max(0, static_cast<int>(rectangle.y) - 1); y < y_end; ++y) {
    for (int x = std::max(0, static_cast<int>(rectangle.x) - 1); x < x_end; ++x) {
      // Signed distance to the outline, negative inside.
      const double dx = std::abs(x + 0.5 - middle_x) - 0.5 * rectangle.width + corner_px;
      const double dy = std::abs(y + 0.5 - middle_y) - 0.5 * rectangle.height + corner_px;
      const double outside = std::hypot(std::max(dx, 0.0), std::max(dy, 0.0));
      const double distance = outside + std::min(std::max(dx, dy), 0.0) - corner_px;
      mask.at<float>(y, x) = static_cast<float>(std::clamp(0.5 - distance, 0.0, 1.0));
    }
  }
  return mask;
}

}  // namespace colmap_ext
