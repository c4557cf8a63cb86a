// Descriptor matchers on the same pairs of photos: ours, on every path of this processor, and
// OpenCV's two.
#pragma once

#include <filesystem>

#include "colmap_ext/sfm/matching.h"
#include "support/bench_report.h"

namespace colmap_ext {

// CPU time a pair of photos, over pairs of the database that were matched; rows "matcher …".
void RaceMatchers(const std::filesystem::path& database_path, const MatchingOptions& options,
                  BenchReport* report);

}  // namespace colmap_ext
