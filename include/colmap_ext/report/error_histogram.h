// The errors of an evaluation as a picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace colmap_ext {

// Share of the samples over their error, 40 bars from 0 to `max_error_m` and one for everything
// beyond, with the cumulative share as a line and a mark at each threshold. CV_8UC3, width x
// height of `size` (at least 320 x 200). Throws Error without errors or for a smaller picture.
cv::Mat DrawErrorHistogram(const std::vector<double>& errors_m, double max_error_m,
                           const std::vector<double>& thresholds_m, const cv::Size& size);

}  // namespace colmap_ext
