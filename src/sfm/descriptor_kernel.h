// The inner loop of the descriptor matcher: dot products of SIFT bytes, and the best two of each.
#pragma once

#include <cstdint>
#include <vector>

#include "colmap_ext/sfm/matching.h"

namespace colmap_ext {

// For one descriptor: largest and second largest dot product with the other photo's descriptors,
// and the lowest index that has the largest. All zero, index -1 when there is no positive product.
struct BestTwo {
  std::int32_t best = 0;
  std::int32_t second = 0;
  std::int32_t index = -1;
  bool operator==(const BestTwo&) const = default;
};

// Index of the match where it passes the ratio and distance tests, else -1.
std::int32_t AcceptedMatch(const BestTwo& candidate, const MatchingOptions& options);

enum class CpuPath { kPortable, kSse2, kAvx2, kAvx512Vnni };
// What this processor can run, the fastest last. All paths give identical results.
std::vector<CpuPath> AvailableCpuPaths();

struct BestTwoBothWays {
  std::vector<BestTwo> of_first;   // one for each descriptor of the first photo
  std::vector<BestTwo> of_second;  // ... of the second
};
BestTwoBothWays FindBestTwo(const DescriptorView& first, const DescriptorView& second,
                            CpuPath path);

// MatchDescriptors, which takes the fastest path, on a given one.
std::vector<KeypointMatch> MatchDescriptorsOn(CpuPath path, const DescriptorView& first,
                                              const DescriptorView& second,
                                              const MatchingOptions& options);

}  // namespace colmap_ext
