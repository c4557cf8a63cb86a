#pragma once

#include <filesystem>

#include "support/bench_report.h"
#include "true_site.h"

namespace colmap_ext {

// Times of one plan after the first flight: of the true site, or of the newest iteration of a
// session when `workspace` is given.
void MeasureSpeed(const TrueSite& site, const std::filesystem::path& workspace, int repetitions,
                  BenchReport* report);

// Rays a second of the planner's visibility test, beside Embree called directly with the same rays.
void MeasureRays(const TrueSite& site, BenchReport* report);

}  // namespace colmap_ext
