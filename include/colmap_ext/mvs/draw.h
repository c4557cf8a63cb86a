// Pictures of superpixels and their confidence, as in the paper's figures.
#pragma once

#include <opencv2/core.hpp>

#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// The photo with polygon edges in yellow and triangle edges in grey, enlarged twice. `bgr`:
// CV_8UC3, the photo that `mesh` partitions.
cv::Mat DrawSuperpixelOverlay(const cv::Mat& bgr, const ImageMesh& mesh);

// Confidence from red (0) over yellow to green (1), dark blue where unsupported, over the photo's
// brightness when `bgr` is not empty. CV_8UC3 of the camera's size.
cv::Mat DrawConfidence(const cv::Mat& bgr, const ViewMesh& mesh);

// Depth from near (bright) to far (dark) between its 2nd and 98th percentile; dark blue where
// unsupported.
cv::Mat DrawDepth(const ViewMesh& mesh);

}  // namespace colmap_ext
