// --jobs: one command's work split over processes (docs/clusters.md).
#pragma once

#include <string>

#include "colmap_ext/util/job_rank.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct JobOptions {
  std::string jobs = "local";
  double wait_s = 3600;
};

void BindOptions(OptionSet& set, JobOptions* options);

// This process's share, as the launcher's environment says. Throws UsageError.
JobRank RankOf(const JobOptions& options);

}  // namespace colmap_ext
