// Residuals of the bundle adjustment with their analytic derivatives.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/sized_cost_function.h>

#include "bundle_state.h"

namespace colmap_ext {

// What many residuals share is computed once an evaluation.
class RefreshState : public ceres::EvaluationCallback {
 public:
  explicit RefreshState(BundleState* state) : state_(state) {}
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) final;

 private:
  BundleState* state_;
};

// (project(X) - x) / sigma, 2 residuals. Parameter blocks, each only when it is free: turn and
// centre of the photo (6), point (3), free intrinsics (n). Reads what RefreshState computed.
class ReprojectionCost : public ceres::CostFunction {
 public:
  ReprojectionCost(const BundleState& state, const BundleObservation& observation, double sigma_px);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const final;

 private:
  const BundlePose* pose_;
  const BundleCamera* camera_;
  const BundlePoint* point_;
  Eigen::Vector2d pixel_;
  double weight_;  // 1 / sigma
};

// (centre - measured) / sigma, 3 residuals.
class PositionPriorCost : public ceres::SizedCostFunction<3, 6> {
 public:
  explicit PositionPriorCost(const PhotoPrior& prior) : prior_(prior) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const final;

 private:
  const PhotoPrior& prior_;
};

// (rotation z - up_in_cam) / sigma, 3 residuals.
class UpPriorCost : public ceres::SizedCostFunction<3, 6> {
 public:
  UpPriorCost(const BundlePose& pose, const PhotoPrior& prior) : pose_(pose), prior_(prior) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const final;

 private:
  const BundlePose& pose_;
  const PhotoPrior& prior_;
};

// Residual of a position prior in sigmas, per axis.
Eigen::Vector3d PositionResidualSigmas(const PhotoPrior& prior, const Eigen::Vector3d& center);

}  // namespace colmap_ext
