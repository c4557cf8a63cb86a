// One round of the bundle adjustment: builds the problem for Ceres and solves it.
#pragma once

#include "bundle_state.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Where the losses begin to discount.
struct LossScales {
  double keypoint_px = 0;  // 0: squares
  double prior = 0;        // sigmas

  bool operator==(const LossScales&) const = default;
};

struct BundleSolve {
  int num_iterations = 0;
  bool converged = false;
};
// Moves the free parts of `state`, living observations only. `scales` replace those of `options`.
// Throws CancelledError.
BundleSolve SolveBundle(const BundleOptions& options, const LossScales& scales,
                        const JobControl& job, BundleState* state);

}  // namespace colmap_ext
