// Depth of one photo from all of its partners, from coarse to fine.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/dense/pair_stereo.h"

namespace colmap_ext {

struct MergedDepth {
  cv::Mat inverse_depth;  // CV_32FC1, 1/z; 0: none
  cv::Mat pairs;          // CV_8UC1: pairs that agree on it, 0 where there is none
};

// Per pixel the largest group of pairs whose inverse depths lie within agreement_px of parallax of
// one of them; its mean, weighted by 1/per_pixel² (long baselines are more exact). Where every pair
// says something else, none. `pairs` must not be empty and be of one size.
MergedDepth MergePairs(const std::vector<PairDepth>& pairs, double agreement_px);

// A map without holes: values of MergedDepth where it has them (crumbs removed), elsewhere smooth
// continuation (push-pull over a pyramid). 1/z of `fallback` where there is nothing at all.
cv::Mat FillHoles(const MergedDepth& depth, float fallback);

// Depth of `reference`: on the coarsest level over the whole range, on every finer one around the
// merged map of the level before. The result is of the reference's size.
MergedDepth EstimateDepth(const StereoView& reference, const std::vector<StereoView>& partners,
                          const DepthRange& range, const DenseStereoOptions& options);

}  // namespace colmap_ext
