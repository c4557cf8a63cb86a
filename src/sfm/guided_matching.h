// More matches of a pair of photos once its epipolar geometry is known.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/sfm/matching.h"

namespace colmap_ext {

// A photo's keypoints as the epipolar matrix takes them (pixels for F, the plane at distance 1 for
// E), one column each, with their descriptors.
struct GuidedPhoto {
  Eigen::Matrix2Xf points;
  DescriptorView descriptors;
  float max_error = 0;  // distance from an epipolar line that is allowed, in the units of `points`
};

// Adds to `matches` (one-to-one) those among the keypoints without match that lie on each other's
// epipolar lines (x2ᵀ matrix x1 = 0) and pass the tests of MatchDescriptors there: the second best
// is that of the line, not of the photo, so that what repeats elsewhere can be told apart. The
// given matches stay; the result is sorted. Throws UsageError for invalid options.
std::vector<KeypointMatch> AddGuidedMatches(const GuidedPhoto& first, const GuidedPhoto& second,
                                            const Eigen::Matrix3d& matrix,
                                            const std::vector<KeypointMatch>& matches,
                                            const MatchingOptions& options);

}  // namespace colmap_ext
