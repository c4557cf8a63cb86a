#pragma once

#include <opencv2/core.hpp>

#include "colmap_ext/report/mesh_picture.h"

namespace colmap_ext {

// Mixes `color` into the picture: by mask * opacity at each pixel. `mask`: CV_32F, 0 … 1, of the
// same size as `bgr` (CV_8UC3).
void BlendColor(const cv::Mat& mask, const Rgb& color, double opacity, cv::Mat* bgr);

// Coverage mask (CV_32F, of `size`) of a rectangle with round corners.
cv::Mat RoundedRectangle(const cv::Size& size, const cv::Rect2d& rectangle, double corner_px);

}  // namespace colmap_ext
