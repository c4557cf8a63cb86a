#include "colmap_ext/sfm/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include "bundle_costs.h"
#include "bundle_solver.h"
#include "bundle_state.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"
#include "gauge.h"

namespace colmap_ext {
namespace {

constexpr double kDisagreementSigmas = 5;

// Positions of free photos in sigmas, one length a photo.
std::vector<double> PriorResiduals(const BundleState& state) {
  std::vector<double> residuals;
  for (const BundlePose& pose : state.poses) {
    if (pose.prior == nullptr || !pose.prior->position_in_world) continue;
    residuals.push_back(PositionResidualSigmas(*pose.prior, pose.center()).norm());
  }
  return residuals;
}

// Reprojection errors of the observations in use, in pixels.
std::vector<double> KeypointErrors(const BundleState& state) {
  std::vector<double> errors;
  for (const BundleObservation& observation : state.observations) {
    if (!observation.is_alive || !state.points[observation.point].is_alive) continue;
    const double error = state.ErrorPx(observation);
    if (std::isfinite(error)) errors.push_back(error);
  }
  return errors;
}

double MedianOrZero(const std::vector<double>& values) {
  return values.empty() ? 0 : MiddleValue(values);
}

LossScales FinalScales(const BundleOptions& options) {
  return {options.loss_scale_px, options.prior_loss_scale};
}

// While the model is still bent, most of it disagrees and must pull all the same: the losses then
// begin at the medians.
LossScales ScalesFor(const BundleState& state, const BundleOptions& options) {
  LossScales scales = FinalScales(options);
  scales.prior = std::max(scales.prior, MedianOrZero(PriorResiduals(state)));
  if (scales.keypoint_px > 0) {
    scales.keypoint_px = std::max(scales.keypoint_px, MedianOrZero(KeypointErrors(state)));
  }
  return scales;
}

// Where the keypoints fit well, much less than the largest error allowed tells a false one.
BundleOptions FilterFor(const BundleState& state, const BundleOptions& options) {
  constexpr double kLeastSigmas = 2;
  BundleOptions filter = options;
  const double limit_px =
      std::max(kLeastSigmas * options.keypoint_sigma_px,
               options.filter_max_medians * MedianOrZero(KeypointErrors(state)));
  filter.filter_max_error_px = std::min(options.filter_max_error_px, limit_px);
  return filter;
}

double RmsPx(const BundleState& state) {
  const std::vector<double> errors = KeypointErrors(state);
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return errors.empty() ? 0 : std::sqrt(sum / static_cast<double>(errors.size()));
}

// Something other than the photos' own agreement fixes place, heading or scale of the free part.
bool IsGaugeHeld(const BundleState& state) {
  const auto holds_pose = [](const BundlePose& pose) { return !pose.is_free; };
  const auto holds_point = [](const BundlePoint& point) { return !point.is_free; };
  const auto measures_up = [](const BundlePose& pose) {
    return pose.prior != nullptr && pose.prior->up_in_cam.has_value();
  };
  return PriorResiduals(state).size() >= 3 ||
         std::any_of(state.poses.begin(), state.poses.end(), holds_pose) ||
         std::any_of(state.poses.begin(), state.poses.end(), measures_up) ||
         std::any_of(state.points.begin(), state.points.end(), holds_point);
}

std::vector<Rigid3d> PosesOf(const BundleState& state) {
  std::vector<Rigid3d> poses;
  for (const BundlePose& pose : state.poses) poses.push_back(pose.CamFromWorld());
  return poses;
}

void RestoreGauge(const std::vector<Rigid3d>& poses_before, BundleState* state) {
  std::vector<PosePair> pairs;
  for (std::size_t k = 0; k < poses_before.size(); ++k) {
    pairs.push_back({poses_before[k], state->poses[k].CamFromWorld()});
  }
  const std::optional<Sim3d> reference_from_moved = ReferenceFromMoved(pairs);
  if (!reference_from_moved) return;  // all photos in one place: nothing tells the scale
  for (BundlePose& pose : state->poses) {
    pose.SetCamFromWorld(TransformCameraWorld(*reference_from_moved, pose.CamFromWorld()));
  }
  for (BundlePoint& point : state->points) {
    point.position = *reference_from_moved * point.position;
  }
}

void ReportPriors(const BundleState& state, BundleResult* result) {
  double sum = 0;
  int num_agreeing = 0;
  for (const BundlePose& pose : state.poses) {
    if (pose.prior == nullptr || !pose.prior->position_in_world) continue;
    const double metres = (pose.center() - *pose.prior->position_in_world).norm();
    const double sigmas = PositionResidualSigmas(*pose.prior, pose.center()).norm();
    if (sigmas > kDisagreementSigmas) {
      result->disagreements.push_back({pose.image_id, metres, sigmas});
    } else {
      sum += metres * metres;
      ++num_agreeing;
    }
  }
  result->prior_rms_m = num_agreeing == 0 ? 0 : std::sqrt(sum / num_agreeing);
  std::stable_sort(result->disagreements.begin(), result->disagreements.end(),
                   [](const PriorDisagreement& a, const PriorDisagreement& b) {
                     return a.residual_sigmas > b.residual_sigmas;
                   });
}

// COLMAP's bounds for intrinsics that a mapper may keep.
bool IsAbsurd(const Camera& camera) {
  const auto num_focal = static_cast<std::size_t>(NumFocalParams(camera.model));
  const double longer = std::max(camera.width, camera.height);
  for (std::size_t k = 0; k < camera.params.size(); ++k) {
    const double param = camera.params[k];
    if (!std::isfinite(param)) return true;
    if (k < num_focal && (param < 0.1 * longer || param > 10 * longer)) return true;
    if (k == num_focal && (param < 0 || param > camera.width)) return true;
    if (k == num_focal + 1 && (param < 0 || param > camera.height)) return true;
    if (k > num_focal + 1 && std::abs(param) > 1) return true;
  }
  return false;
}

std::vector<CameraId> AbsurdCameras(const BundleState& state) {
  std::vector<CameraId> ids;
  for (const BundleCamera& camera : state.cameras) {
    if (!camera.free_params.empty() && IsAbsurd(camera.camera)) ids.push_back(camera.camera_id);
  }
  return ids;
}

BundleResult CountProblem(const BundleState& state) {
  BundleResult result;
  for (const BundlePose& pose : state.poses) result.num_free_images += pose.is_free ? 1 : 0;
  for (const BundlePoint& point : state.points) result.num_free_points += point.is_free ? 1 : 0;
  result.num_observations = state.observations.size();
  result.initial_rms_px = RmsPx(state);
  return result;
}

// Rounds of adjusting and filtering.
BundleResult RunRounds(const BundleOptions& options, const JobControl& job, BundleState* state) {
  BundleResult result = CountProblem(*state);
  const std::vector<Rigid3d> poses_before = PosesOf(*state);
  const bool is_gauge_held = IsGaugeHeld(*state);
  while (result.num_rounds < options.max_rounds) {
    ++result.num_rounds;
    const bool is_last = result.num_rounds == options.max_rounds;
    const LossScales scales = is_last ? FinalScales(options) : ScalesFor(*state, options);
    const BundleSolve solve = SolveBundle(options, scales, job, state);
    result.num_iterations += solve.num_iterations;
    result.converged = solve.converged;
    if (scales != FinalScales(options)) continue;  // too early to judge observations
    const FilterCounts filtered = FilterBundle(FilterFor(*state, options), state);
    result.num_filtered_observations += filtered.observations;
    result.num_filtered_points += filtered.points;
    if (static_cast<double>(filtered.observations) <=
        options.max_filtered_part * static_cast<double>(result.num_observations)) {
      break;
    }
  }
  if (!is_gauge_held) RestoreGauge(poses_before, state);
  result.final_rms_px = RmsPx(*state);
  ReportPriors(*state, &result);
  return result;
}

}  // namespace

std::string BundleOptions::Check() const {
  if (!(keypoint_sigma_px > 0)) return "BundleAdjustment.keypoint_sigma_px must be above 0 px";
  if (!(loss_scale_px >= 0)) return "BundleAdjustment.loss_scale_px must be at least 0 px";
  if (!(prior_loss_scale > 0)) return "BundleAdjustment.prior_loss_scale must be above 0";
  if (max_iterations < 1) return "BundleAdjustment.max_iterations must be at least 1";
  if (!(function_tolerance >= 0 && function_tolerance < 1)) {
    return "BundleAdjustment.function_tolerance must be at least 0 and below 1";
  }
  if (max_rounds < 1) return "BundleAdjustment.max_rounds must be at least 1";
  if (!(max_filtered_part >= 0 && max_filtered_part <= 1)) {
    return "BundleAdjustment.max_filtered_part must be from 0 to 1";
  }
  if (!(filter_max_error_px > 0)) return "BundleAdjustment.filter_max_error_px must be above 0 px";
  if (!(filter_max_medians >= 1)) return "BundleAdjustment.filter_max_medians must be at least 1";
  if (!(filter_min_angle_deg >= 0 && filter_min_angle_deg < 90)) {
    return "BundleAdjustment.filter_min_angle_deg must be at least 0 and below 90 degrees";
  }
  return "";
}

void BindOptions(OptionSet& set, BundleOptions* options) {
  const auto add = [&set](const char* name, auto* value, const char* help) {
    set.Add("BundleAdjustment", name, value, help);
  };
  add("keypoint_sigma_px", &options->keypoint_sigma_px,
      "error of a keypoint when it is weighed against measured positions (px, > 0)");
  add("loss_scale_px", &options->loss_scale_px,
      "where the soft L1 loss of reprojection errors turns linear, 0: squares (px, >= 0)");
  add("prior_loss_scale", &options->prior_loss_scale,
      "where the loss of measured positions starts to discount them (sigmas, > 0)");
  add("refine_focal_length", &options->refine_focal_length, "estimate focal lengths (0 or 1)");
  add("refine_principal_point", &options->refine_principal_point,
      "estimate principal points (0 or 1)");
  add("refine_extra_params", &options->refine_extra_params, "estimate distortion (0 or 1)");
  add("max_iterations", &options->max_iterations, "of one round (>= 1)");
  add("function_tolerance", &options->function_tolerance,
      "relative change of the cost that ends a round (0 <= t < 1)");
  add("max_rounds", &options->max_rounds, "rounds of adjusting and filtering (>= 1)");
  add("max_filtered_part", &options->max_filtered_part,
      "a round that filters no more of the observations is the last one (0 … 1)");
  add("filter_max_error_px", &options->filter_max_error_px,
      "observations with larger reprojection errors are dropped (px, > 0)");
  add("filter_max_medians", &options->filter_max_medians,
      "... and those of more than so many times the median error, but not below two "
      "keypoint_sigma_px (>= 1)");
  add("filter_min_angle_deg", &options->filter_min_angle_deg,
      "points whose rays meet at smaller angles are dropped (deg, 0 <= a < 90)");
}

BundleResult AdjustBundle(const BundleSelection& selection, const BundleOptions& options,
                          const JobControl& job, Reconstruction* model) {
  ThrowIfInvalid(options.Check());
  BundleState state = GatherBundle(selection, options, {}, *model);
  BundleResult result = RunRounds(options, job, &state);
  const std::vector<CameraId> absurd = AbsurdCameras(state);
  if (!absurd.empty()) {
    state = GatherBundle(selection, options, absurd, *model);
    result = RunRounds(options, job, &state);
    result.refused_cameras = absurd;
  }
  ApplyBundle(state, model);
  return result;
}

}  // namespace colmap_ext
