#pragma once

#include "colmap_ext/report/summary.h"

namespace colmap_ext {

inline SessionSummary MadeUpSession(int iterations) {
  SessionSummary summary;
  summary.finished = "covered";
  for (int i = 0; i < iterations; ++i) {
    IterationSummary iteration;
    iteration.photos = 64 + 8 * i;
    iteration.registered = iteration.photos - 2 * (i % 2);
    iteration.covered_ratio = 1 - 0.5 / (1 + i);
    iteration.reachable_covered_ratio = 1 - 0.4 / (1 + i);
    iteration.planned_views = 8;
    iteration.mean_error_m = 0.08 / (1 + i);
    iteration.rms_error_m = 0.1 / 3 / (1 + i);
    iteration.completeness = {{"25.4mm", 0.3 + 0.1 * i / iterations * 2}, {"50.8mm", 0.75}};
    iteration.wall_s = 61 + i;
    iteration.stage_wall_s = {{"sparse", 30.5}, {"superpixels", 4}, {"stereo", 8},
                              {"fusion", 1.25}, {"surface", 5},     {"coverage", 2},
                              {"nbv", 3},       {"path", 0.5},      {"capture", 4}};
    if (i % 2 == 1) iteration.unregistered = {"a <b>&\"c'.jpg", "photo_0071.jpg"};
    summary.iterations.push_back(iteration);
  }
  return summary;
}

}  // namespace colmap_ext
