// Depth maps to one cloud.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/dense/depth_filter.h"
#include "colmap_ext/scene/oriented_points.h"

namespace colmap_ext {

struct FusionView {
  DepthView depth;
  cv::Mat normal;  // CV_32FC3, as in PlaneMaps
  cv::Mat photos;  // CV_8UC1, as in ConfirmedDepth
  cv::Mat bgr;     // CV_8UC3, same size; empty: points stay black
  int photo_index = 0;
};

// Points of one photo, by row: every fusion_step_px-th pixel of every fusion_step_px-th row, unless
// another view that confirms the point saw it finer (smaller depth by focal length; the lower photo
// index at a tie): that one gives it. The position is the mean of all views that confirm it,
// weighted by 1/pixel size². confidence = 1 − 1/photos. The result depends on the views only, so
// photos can be fused in any order and by any number of threads.
OrientedPoints FuseView(const FusionView& view, const std::vector<FusionView>& others,
                        const DenseStereoOptions& options);

}  // namespace colmap_ext
