#include "colmap_ext/sfm/matching.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "descriptor_kernel.h"

namespace colmap_ext {
namespace {

// COLMAP normalises descriptors to length 512: dot / 512^2 is the cosine of their angle.
float AngleOf(std::int32_t dot) {
  return std::acos(std::min(static_cast<float>(dot) / (512.0F * 512.0F), 1.0F));
}

}  // namespace

std::int32_t AcceptedMatch(const BestTwo& candidate, const MatchingOptions& options) {
  if (candidate.index < 0) return -1;
  const float angle = AngleOf(candidate.best);
  if (angle > static_cast<float>(options.max_distance)) return -1;
  if (angle >= static_cast<float>(options.max_ratio) * AngleOf(candidate.second)) return -1;
  return candidate.index;
}

std::string MatchingOptions::Check() const {
  if (!(max_ratio > 0 && max_ratio <= 1)) {
    return "Matching.max_ratio must be above 0 and at most 1";
  }
  if (!(max_distance > 0 && max_distance <= 1.5708)) {
    return "Matching.max_distance must be above 0 and at most 1.5708 rad";
  }
  if (!(guided_max_error_px >= 0)) return "Matching.guided_max_error_px must be at least 0 px";
  return "";
}

void BindOptions(OptionSet& set, MatchingOptions* options) {
  set.Add("Matching", "max_ratio", &options->max_ratio,
          "angle to the best match by angle to the second best (0 < r <= 1)");
  set.Add("Matching", "max_distance", &options->max_distance,
          "largest angle between matching descriptors (rad, 0 < d <= 1.5708)");
  set.Add("Matching", "cross_check", &options->cross_check,
          "keep only matches that are the best both ways (0 or 1)");
  set.Add("Matching", "guided_max_error_px", &options->guided_max_error_px,
          "match again near the epipolar lines of verified pairs, 0: no (px, >= 0)");
}

std::vector<KeypointMatch> MatchDescriptors(const DescriptorView& first,
                                            const DescriptorView& second,
                                            const MatchingOptions& options) {
  return MatchDescriptorsOn(AvailableCpuPaths().back(), first, second, options);
}

std::vector<KeypointMatch> MatchDescriptorsOn(CpuPath path, const DescriptorView& first,
                                              const DescriptorView& second,
                                              const MatchingOptions& options) {
  ThrowIfInvalid(options.Check());
  const BestTwoBothWays best = FindBestTwo(first, second, path);
  std::vector<KeypointMatch> matches;
  for (std::size_t i = 0; i < best.of_first.size(); ++i) {
    const std::int32_t j = AcceptedMatch(best.of_first[i], options);
    if (j < 0) continue;
    if (options.cross_check) {
      const BestTwo& back = best.of_second[static_cast<std::size_t>(j)];
      if (AcceptedMatch(back, options) != static_cast<std::int32_t>(i)) continue;
    }
    matches.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
  }
  return matches;
}

std::vector<std::vector<KeypointMatch>> MatchPhotoPairs(const std::vector<DescriptorView>& photos,
                                                        const std::vector<PhotoPair>& pairs,
                                                        const MatchingOptions& options,
                                                        const JobControl& job) {
  ThrowIfInvalid(options.Check());
  std::vector<std::vector<KeypointMatch>> matches(pairs.size());
  std::atomic<std::size_t> done = 0;
  ParallelFor(pairs.size(), [&](std::size_t i) {
    if (job.IsCancelled()) return;
    matches[i] = MatchDescriptors(photos[static_cast<std::size_t>(pairs[i].first)],
                                  photos[static_cast<std::size_t>(pairs[i].second)], options);
    job.Progress("matching", ++done, pairs.size());
  });
  job.ThrowIfCancelled();
  return matches;
}

}  // namespace colmap_ext
