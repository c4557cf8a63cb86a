// A texture prepared for rendering: a pyramid of area-averaged levels, so that far texture does not
// alias.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

namespace colmap_ext {

class MipTexture {
 public:
  // `bgr` CV_8UC3, not empty.
  explicit MipTexture(const cv::Mat& bgr);

  int width() const { return levels_.front().cols; }
  int height() const { return levels_.front().rows; }
  int NumLevels() const { return static_cast<int>(levels_.size()); }

  // Bilinear in `level` (0 is the finest; clamped), repeating; v = 1 is the upper edge. BGR 0 …
  // 255, display values.
  Eigen::Vector3f Sample(float u, float v, int level) const;

 private:
  std::vector<cv::Mat> levels_;  // CV_8UC4: four bytes a texel are one load
};

}  // namespace colmap_ext
