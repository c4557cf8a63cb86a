// Photos of distorting cameras as an ideal pinhole camera would have taken them.
#pragma once

#include <opencv2/core.hpp>

#include "colmap_ext/geom/camera.h"

namespace colmap_ext {

// For every pixel of `pinhole`, where `camera` sees the same ray: CV_32FC2, pinhole.width x
// pinhole.height, in OpenCV's pixel convention as cv::remap takes it.
cv::Mat BuildUndistortMap(const Camera& camera, const PinholeCamera& pinhole);

// The photo seen through the map, bilinear. Pixels that the photo does not show repeat its border,
// which makes no edge where the picture has none.
cv::Mat Undistort(const cv::Mat& photo, const cv::Mat& map);

}  // namespace colmap_ext
