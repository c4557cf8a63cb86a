// Our own descriptor matcher: brute force over SIFT bytes in exact integer arithmetic, so that the
// same photos give the same matches on every run and with any number of threads (COLMAP's FLANN
// search does not), and several times faster.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/pairing.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

inline constexpr int kDescriptorSize = 128;  // bytes

// The same tests as COLMAP's SiftMatching, with its defaults.
struct MatchingOptions {
  // The angle to the best match must be below max_ratio times the angle to the second best; (0, 1].
  double max_ratio = 0.8;
  double max_distance = 0.7;  // largest angle between descriptors of 512 length; rad, (0, pi/2]
  bool cross_check = true;    // keep only pairs that are each other's best match
  // Pairs that are verified are matched again among keypoints so near to each other's epipolar
  // lines; px, >= 0, 0: not.
  double guided_max_error_px = 4;

  std::string Check() const;
};
void BindOptions(OptionSet& set, MatchingOptions* options);  // section "Matching"

// The descriptors of a photo: count x 128 bytes, row by row, not owned.
struct DescriptorView {
  const std::uint8_t* bytes = nullptr;
  int count = 0;
};

// Matches of two photos, sorted by the first index, which occurs once. Throws UsageError for
// invalid options.
std::vector<KeypointMatch> MatchDescriptors(const DescriptorView& first,
                                            const DescriptorView& second,
                                            const MatchingOptions& options);

// MatchDescriptors for every pair, in parallel. `pairs` index `photos`; result i belongs to pair i.
// Throws CancelledError when `job` is cancelled.
std::vector<std::vector<KeypointMatch>> MatchPhotoPairs(const std::vector<DescriptorView>& photos,
                                                        const std::vector<PhotoPair>& pairs,
                                                        const MatchingOptions& options,
                                                        const JobControl& job);

}  // namespace colmap_ext
