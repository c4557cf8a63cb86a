// Which photos are matched with which, and how deep each one looks.
#pragma once

#include <vector>

#include "colmap_ext/dense/options.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

// For every photo at most options.num_partners others, best first. The score of a pair is the sum
// over the points both see of
//   a(θ) · (min(r_i, r_j) / max(r_i, r_j))²
// with θ the angle between the two rays, r the distances of the point (photos of like resolution
// match best), and a = θ/min_angle below min_angle_deg, 1 up to good_angle_deg, falling to 0 at
// max_angle_deg. Ties go to the photo with the lower index. A photo without shared points has none.
std::vector<std::vector<int>> ChooseStereoPartners(const PhotoSet& photos,
                                                   const DenseStereoOptions& options);

// Depths along the optical axis, in the unit of the world; 0 < min < max, or both 0: unknown.
struct DepthRange {
  double min = 0;
  double max = 0;
  bool IsKnown() const { return min > 0 && max > min; }
};

// From `depths` of one photo (any order): 0.5th to 99.5th percentile, widened to 0.7 and 1.5 times,
// for what the samples miss. Unknown when there are fewer than 5.
DepthRange RangeOfDepths(std::vector<float> depths);

// Depths of the points that each photo sees, in front of it.
std::vector<std::vector<float>> DepthsOfPoints(const PhotoSet& photos);

}  // namespace colmap_ext
