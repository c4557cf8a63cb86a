#include "bundle_solver.h"

#include <ceres/iteration_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <deque>
#include <memory>

#include "bundle_costs.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

class StopWhenCancelled : public ceres::IterationCallback {
 public:
  explicit StopWhenCancelled(const JobControl& job) : job_(job) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) final {
    return job_.IsCancelled() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const JobControl& job_;
};

// Owns the residuals of one ceres::Problem.
class Builder {
 public:
  Builder(const BundleOptions& options, const LossScales& scales, BundleState* state)
      : options_(options), state_(*state), refresh_(state), prior_loss_(scales.prior) {
    if (scales.keypoint_px > 0) {
      const double scale = scales.keypoint_px / options.keypoint_sigma_px;
      reprojection_loss_ = std::make_unique<ceres::SoftLOneLoss>(scale);
    }
    ceres::Problem::Options problem_options;
    problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.disable_all_safety_checks = true;
    problem_options.evaluation_callback = &refresh_;
    problem_ = std::make_unique<ceres::Problem>(problem_options);
    AddObservations();
    AddPriors();
  }

  ceres::Problem* problem() { return problem_.get(); }

  // Points are eliminated first.
  std::shared_ptr<ceres::ParameterBlockOrdering> Ordering() {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (BundlePoint& point : state_.points) {
      if (problem_->HasParameterBlock(point.position.data())) {
        ordering->AddElementToGroup(point.position.data(), 0);
        ++num_points_;
      }
    }
    for (BundlePose& pose : state_.poses) {
      if (problem_->HasParameterBlock(pose.turn_and_center)) {
        ordering->AddElementToGroup(pose.turn_and_center, 1);
        ++num_poses_;
      }
    }
    for (BundleCamera& camera : state_.cameras) {
      if (problem_->HasParameterBlock(camera.free_values)) {
        ordering->AddElementToGroup(camera.free_values, 1);
      }
    }
    return ordering;
  }
  int num_points() const { return num_points_; }  // after Ordering
  int num_poses() const { return num_poses_; }    // ...

 private:
  void AddObservations() {
    for (const BundleObservation& observation : state_.observations) {
      if (!observation.is_alive || !state_.points[observation.point].is_alive) continue;
      if (!(state_.PointInCam(observation).z() > 0)) continue;  // the filter takes it
      BundlePose& pose = state_.poses[observation.pose];
      BundlePoint& point = state_.points[observation.point];
      BundleCamera& camera = state_.cameras[pose.camera];
      double* blocks[3];
      int num_blocks = 0;
      if (pose.is_free) blocks[num_blocks++] = pose.turn_and_center;
      if (point.is_free) blocks[num_blocks++] = point.position.data();
      if (!camera.free_params.empty()) blocks[num_blocks++] = camera.free_values;
      if (num_blocks == 0) continue;
      costs_.emplace_back(state_, observation, options_.keypoint_sigma_px);
      problem_->AddResidualBlock(&costs_.back(), reprojection_loss_.get(), blocks, num_blocks);
    }
  }

  void AddPriors() {
    for (BundlePose& pose : state_.poses) {
      if (pose.prior == nullptr) continue;
      if (pose.prior->position_in_world) {
        position_costs_.emplace_back(*pose.prior);
        problem_->AddResidualBlock(&position_costs_.back(), &prior_loss_, pose.turn_and_center);
      }
      if (pose.prior->up_in_cam) {
        up_costs_.emplace_back(pose, *pose.prior);
        problem_->AddResidualBlock(&up_costs_.back(), &prior_loss_, pose.turn_and_center);
      }
    }
  }

  const BundleOptions& options_;
  BundleState& state_;
  RefreshState refresh_;
  std::unique_ptr<ceres::LossFunction> reprojection_loss_;
  ceres::CauchyLoss prior_loss_;
  std::deque<ReprojectionCost> costs_;  // addresses stay
  std::deque<PositionPriorCost> position_costs_;
  std::deque<UpPriorCost> up_costs_;
  std::unique_ptr<ceres::Problem> problem_;
  int num_points_ = 0, num_poses_ = 0;
};

// Share of the pairs of free poses that see a point together: how full the equations are once the
// points are eliminated.
double SharedPairs(const BundleState& state) {
  const std::size_t count = state.poses.size();
  std::vector<bool> is_shared(count * count);
  std::size_t shared = 0, free_poses = 0;
  for (const BundlePose& pose : state.poses) free_poses += pose.is_free ? 1 : 0;
  for (const BundlePoint& point : state.points) {
    if (!point.is_free || !point.is_alive) continue;
    std::vector<std::size_t> seen_by;
    for (std::size_t k = 0; k < point.num_observations; ++k) {
      const BundleObservation& observation = state.observations[point.first_observation + k];
      if (observation.is_alive && state.poses[observation.pose].is_free) {
        seen_by.push_back(observation.pose);
      }
    }
    for (const std::size_t i : seen_by) {
      for (const std::size_t j : seen_by) {
        if (i >= j || is_shared[i * count + j]) continue;
        is_shared[i * count + j] = true;
        ++shared;
      }
    }
  }
  const auto poses = static_cast<double>(free_poses);
  return free_poses < 2 ? 0 : 2 * static_cast<double>(shared) / (poses * (poses - 1));
}

// Many photos around one building share points with many others: the equations are full, and a
// factorisation grows with the cube of the poses. There conjugate gradients are as quick at 280
// photos, and five times at 1,032. Along a road the equations are thin, and a sparse factorisation
// is seven times as quick at 450.
ceres::LinearSolverType LinearSolverFor(int num_points, int num_poses, const BundleState& state) {
  if (num_points == 0 || num_poses == 0) return ceres::SPARSE_NORMAL_CHOLESKY;
  constexpr int kMaxDensePoses = 400;
  constexpr double kFull = 0.2;
  if (num_poses <= kMaxDensePoses) return ceres::DENSE_SCHUR;
  return SharedPairs(state) > kFull ? ceres::ITERATIVE_SCHUR : ceres::SPARSE_SCHUR;
}

}  // namespace

BundleSolve SolveBundle(const BundleOptions& options, const LossScales& scales,
                        const JobControl& job, BundleState* state) {
  Builder builder(options, scales, state);
  if (builder.problem()->NumResidualBlocks() == 0) return {0, true};
  StopWhenCancelled stop_when_cancelled(job);
  ceres::Solver::Options solver;
  solver.linear_solver_ordering = builder.Ordering();
  solver.linear_solver_type = LinearSolverFor(builder.num_points(), builder.num_poses(), *state);
  if (solver.linear_solver_type == ceres::SPARSE_NORMAL_CHOLESKY) {
    solver.linear_solver_ordering.reset();
  }
  solver.dense_linear_algebra_library_type = ceres::EIGEN;  // the same bits with any BLAS
  solver.num_threads = 1;  // several add up in the order in which they finish
  solver.preconditioner_type = ceres::SCHUR_JACOBI;  // of ITERATIVE_SCHUR
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-10;
  solver.parameter_tolerance = 0;
  // Damping of at least this much keeps the equations solvable where nothing holds the gauge.
  solver.max_trust_region_radius = 1e8;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&stop_when_cancelled);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, builder.problem(), &summary);
  job.ThrowIfCancelled();
  RefreshState(state).PrepareForEvaluation(false, true);
  return {static_cast<int>(summary.iterations.size()) - 1,
          summary.termination_type == ceres::CONVERGENCE};
}

}  // namespace colmap_ext
