// A photo with what the fast stereo made of it.
#pragma once

#include <opencv2/core.hpp>

#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// The photo (CV_8UC3, of the size the mesh was made for) with the outlines of its superpixels, and
// fainter those of their triangles. `width_px`: of the picture, >= 16. Throws Error for an empty
// photo.
cv::Mat DrawSuperpixels(const cv::Mat& bgr, const ImageMesh& mesh, int width_px = 1280);

// The photo in grey with each triangle in the colour of its confidence Γ, 0 (dark) … 1 (bright),
// and a scale. Triangles that no SfM point supports stay grey. Throws Error for an empty photo or
// when sizes disagree.
cv::Mat DrawConfidence(const cv::Mat& bgr, const ViewMesh& mesh, int width_px = 1280);

}  // namespace colmap_ext
