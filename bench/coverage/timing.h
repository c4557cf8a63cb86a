// What surface and coverage cost, beside `colmap poisson_mesher`.
#pragma once

#include "colmap_ext/coverage/coverage.h"
#include "support/bench_report.h"
#include "support/flown_site.h"

namespace colmap_ext {

// The fast cloud of a flight to its surface, in this process and by the mesher of the `colmap` on
// the PATH (same points inside the region, the octree depth with about the same number of
// vertices, as many threads as cores); their errors against the truth (median and 90th percentile
// of the distances of what they hold to it, and of the truth seen to them); and the coverage map.
// Rows begin with `name`.
void MeasureTimes(const std::string& name, const Site& site, const FlightModels& models,
                  const CoverageOptions& options, BenchReport* report, const JobControl& job);

}  // namespace colmap_ext
