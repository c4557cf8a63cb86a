// Depth of a photo from one partner: semi-global matching along epipolar lines.
#pragma once

#include <opencv2/core.hpp>

#include "colmap_ext/dense/options.h"
#include "colmap_ext/dense/stereo_partners.h"
#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

struct StereoView {
  PinholeCamera camera;
  Rigid3d cam_from_world;
  cv::Mat gray;  // CV_8UC1, camera.width x camera.height
};

// What is known before matching.
struct StereoSearch {
  DepthRange range;       // of the reference photo
  cv::Mat inverse_depth;  // CV_32FC1, 1/z everywhere, any size of the photo's field of view; empty:
                          // the whole range is searched, else residual_px around it
};

struct PairDepth {
  cv::Mat inverse_depth;  // CV_32FC1 of the reference's size: 1/z; 0 where there is no match
  cv::Mat per_pixel;      // CV_32FC1: change of 1/z by one pixel of parallax, > 0 where matched
};

// Both photos are sampled once, the reference on its epipolar image and the partner where the prior
// surface says that it shows the same (so that slanted surfaces match without disparity steps, and
// a small search is enough); then OpenCV's SGBM (Hirschmüller 2008), three-way, with its left-right
// check, finds the rest. The result is exact for any prior: the prior decides where it is searched,
// not what the match means. Matches outside the range widened to [0.5 min, 2 max] are dropped.
// Throws Error when the photos were taken from the same place.
PairDepth MatchPair(const StereoView& reference, const StereoView& partner,
                    const StereoSearch& search, const DenseStereoOptions& options);

// Linear interpolation of a map with holes (<= 0) at a continuous OpenCV pixel position: between
// the four neighbours when all are there and their relative difference is below `max_step`, else
// the nearest one; 0 outside.
float SampleSmooth(const cv::Mat& map, double col, double row, double max_step);

}  // namespace colmap_ext
