#include "colmap_ext/sfm/georegistration.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"
#include "colmap_ext/util/text.h"
#include "similarity_sampling.h"

namespace colmap_ext {
namespace {

using Observations = std::vector<CameraObservation>;

// The correction that Ceres looks for: world = pivot + exp(p0) R(p1..3) (guess - pivot) + p4..6.
// Around identity, so that nothing is singular and all parameters are of one size.
constexpr int kNumParameters = 7;

struct PositionResidual {
  Eigen::Vector3d guess_from_pivot, measured_from_pivot, weights;

  template <typename T>
  bool operator()(const T* p, T* residual) const {
    const T point[3] = {T(guess_from_pivot.x()), T(guess_from_pivot.y()), T(guess_from_pivot.z())};
    T turned[3];
    ceres::AngleAxisRotatePoint(p + 1, point, turned);
    for (int k = 0; k < 3; ++k) {
      residual[k] = T(weights[k]) * (exp(p[0]) * turned[k] + p[4 + k] - T(measured_from_pivot[k]));
    }
    return true;
  }
};

// Height of an axis of a camera that should be level: the right one when it has no roll.
struct LevelResidual {
  Eigen::Vector3d axis_in_world;
  double weight;

  template <typename T>
  bool operator()(const T* p, T* residual) const {
    const T axis[3] = {T(axis_in_world.x()), T(axis_in_world.y()), T(axis_in_world.z())};
    T turned[3];
    ceres::AngleAxisRotatePoint(p + 1, axis, turned);
    residual[0] = T(weight) * turned[2];
    return true;
  }
};

Sim3d CorrectionFrom(const std::array<double, kNumParameters>& p, const Eigen::Vector3d& pivot) {
  Sim3d correction;
  correction.scale = std::exp(p[0]);
  double quaternion[4];
  ceres::AngleAxisToQuaternion(p.data() + 1, quaternion);
  correction.rotation =
      Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).normalized();
  correction.translation =
      pivot + Eigen::Vector3d(p[4], p[5], p[6]) - correction.scale * (correction.rotation * pivot);
  return correction;
}

// Holds an axis level beside positions that err by `sigma_m`.
void AddLevelAxis(const Eigen::Vector3d& axis_in_world, double sigma_m,
                  const GeoregistrationOptions& options, double* p, ceres::Problem* problem) {
  auto* level =
      new LevelResidual{axis_in_world, sigma_m / std::sin(DegToRad(options.level_roll_deg))};
  problem->AddResidualBlock(
      new ceres::AutoDiffCostFunction<LevelResidual, 1, kNumParameters>(level),
      new ceres::CauchyLoss(options.loss_scale_m), p);
}

// Where the loss begins: never among the residuals that the positions have anyway. Twice the median
// length is three sigmas of an axis, within a few percent of least squares for Gaussian errors.
double LossScale(const Sim3d& guess, const Observations& cameras,
                 const GeoregistrationOptions& options) {
  std::vector<double> residuals;
  for (const CameraObservation& camera : cameras) residuals.push_back(ResidualOf(guess, camera));
  return std::max(options.loss_scale_m, 2 * MiddleValue(std::move(residuals)));
}

// `sigma_m`: that of positions with weight 1.
Sim3d Refine(const Sim3d& guess, const Observations& cameras, bool level_cameras, double sigma_m,
             const GeoregistrationOptions& options) {
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  for (const CameraObservation& camera : cameras) {
    pivot += camera.position_in_world / static_cast<double>(cameras.size());
  }
  const double loss_scale_m = LossScale(guess, cameras, options);
  std::array<double, kNumParameters> p{};
  ceres::Problem problem;
  for (const CameraObservation& camera : cameras) {
    auto* position = new PositionResidual{guess * camera.center_in_model - pivot,
                                          camera.position_in_world - pivot, camera.weights};
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PositionResidual, 3, kNumParameters>(position),
        new ceres::CauchyLoss(loss_scale_m), p.data());
    const Eigen::Vector3d right = guess.rotation * camera.right_in_model;
    if (camera.forward_in_model) {
      AddLevelAxis(right, sigma_m, options, p.data(), &problem);
      AddLevelAxis(guess.rotation * *camera.forward_in_model, sigma_m, options, p.data(), &problem);
    } else if (level_cameras) {
      AddLevelAxis(right, options.loss_scale_m, options, p.data(), &problem);
    }
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.num_threads = 1;  // sums in one order: the same result everywhere
  solver.max_num_iterations = 200;
  solver.function_tolerance = solver.gradient_tolerance = solver.parameter_tolerance = 1e-16;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return CorrectionFrom(p, pivot) * guess;
}

Observations Agreeing(const Sim3d& world_from_model, const Observations& cameras, double limit_m) {
  Observations agreeing;
  for (const CameraObservation& camera : cameras) {
    if (ResidualOf(world_from_model, camera) <= limit_m) agreeing.push_back(camera);
  }
  return agreeing;
}

// Fits once; `result` gets the similarity, or the refusal.
void Fit(const Observations& cameras, bool level_cameras, double sigma_m,
         const GeoregistrationOptions& options, GeoregistrationResult* result, Observations* used) {
  result->world_from_model.reset();
  result->gravity_from_cameras = level_cameras;
  std::optional<Sim3d> fit = SampleSimilarity(cameras, level_cameras, options);
  if (!fit) {
    result->refusal = "the measured positions or the camera centres do not spread";
    return;
  }
  fit = Refine(*fit, cameras, level_cameras, sigma_m, options);
  for (int pass = 0; pass < 2; ++pass) {
    *used = Agreeing(*fit, cameras, options.max_residual_m);
    if (used->size() < 3 || 2 * used->size() <= cameras.size()) {
      result->refusal = "only " + std::to_string(used->size()) + " of " +
                        std::to_string(cameras.size()) + " measured positions agree with the model";
      return;
    }
    fit = Refine(*fit, *used, level_cameras, sigma_m, options);
  }
  result->world_from_model = fit;
}

// Residual of one coordinate that the fit predicts for the measurements, metres.
double MeasurementSigma(const Sim3d& fit, const Observations& used) {
  double sum = 0;
  for (const CameraObservation& camera : used) sum += std::pow(ResidualOf(fit, camera), 2);
  const double freedom = static_cast<double>(3 * used.size()) - kNumParameters;
  return std::sqrt(sum / freedom);
}

// One sigma of the rotation about the line that fits the centres best, degrees.
double TiltUncertaintyDeg(const Sim3d& fit, const Observations& used) {
  const double spread_m = fit.scale * PrincipalExtents(used)(1);
  const double root_n = std::sqrt(static_cast<double>(used.size()));
  // Centres on one line to a millionth leave the rotation to rounding, whatever the residuals say.
  const bool on_a_line = PrincipalExtents(used)(1) < 1e-6 * PrincipalExtents(used)(0);
  if (on_a_line) return 180;
  return std::min(180.0, RadToDeg(MeasurementSigma(fit, used) / (spread_m * root_n)));
}

Eigen::Vector3d MainAxisInWorld(const Sim3d& fit, const Observations& used) {
  Eigen::Matrix3Xd centers(3, used.size());
  for (std::size_t k = 0; k < used.size(); ++k) {
    centers.col(static_cast<Eigen::Index>(k)) = fit * used[k].center_in_model;
  }
  centers.colwise() -= centers.rowwise().mean().eval();
  return centers.jacobiSvd(Eigen::ComputeFullU).matrixU().col(0);
}

double LevelTiltUncertaintyDeg(const Sim3d& fit, const Observations& used,
                               const GeoregistrationOptions& options) {
  const double stiffness = LevelStiffness(used, fit, MainAxisInWorld(fit, used));
  const double root_n = std::sqrt(static_cast<double>(used.size()));
  return std::min(180.0, options.level_roll_deg / std::max(1e-9, stiffness * root_n));
}

void Refuse(const std::string& reason, GeoregistrationResult* result) {
  result->world_from_model.reset();
  result->refusal = reason;
}

std::string Rounded(double value) { return FormatNumber("%.1f", value); }

// Refuses a fit whose scale or tilt the measurements do not determine.
void CheckCertainty(const Observations& used, const GeoregistrationOptions& options,
                    GeoregistrationResult* result) {
  const Sim3d& fit = *result->world_from_model;
  const double spread_m = fit.scale * PrincipalExtents(used)(0);
  const double root_n = std::sqrt(static_cast<double>(used.size()));
  constexpr double kMaxScaleUncertainty = 0.1;
  if (!(MeasurementSigma(fit, used) < kMaxScaleUncertainty * spread_m * root_n)) {
    Refuse("the measured positions spread too little against their errors to give a scale", result);
  } else if (result->tilt_uncertainty_deg > options.max_tilt_deg) {
    Refuse(
        "the camera centres are on one line, and the cameras do not tell which way is up "
        "(tilt uncertain by " +
            Rounded(result->tilt_uncertainty_deg) + " degrees)",
        result);
  }
}

void ReportResiduals(const std::vector<MeasuredCamera>& cameras,
                     const GeoregistrationOptions& options, GeoregistrationResult* result) {
  double sum = 0;
  for (const MeasuredCamera& camera : cameras) {
    PhotoResidual residual;
    residual.name = camera.name;
    residual.offset_m =
        *result->world_from_model * CameraCenter(camera.cam_from_model) - camera.position_in_world;
    residual.residual_m = residual.offset_m.norm();
    residual.is_outlier = residual.residual_m > options.max_residual_m;
    result->residuals.push_back(residual);
    if (residual.is_outlier) {
      result->outliers.push_back(residual);
      continue;
    }
    sum += residual.residual_m * residual.residual_m;
    result->max_m = std::max(result->max_m, residual.residual_m);
    result->num_attitudes += camera.up_in_cam ? 1 : 0;
    ++result->num_used;
  }
  result->rms_m = result->num_used == 0 ? 0 : std::sqrt(sum / result->num_used);
  std::stable_sort(
      result->outliers.begin(), result->outliers.end(),
      [](const PhotoResidual& a, const PhotoResidual& b) { return a.residual_m > b.residual_m; });
}

}  // namespace

std::string GeoregistrationOptions::Check() const {
  if (!(max_residual_m > 0)) return "Georegistration.max_residual_m must be above 0 m";
  if (!(loss_scale_m > 0)) return "Georegistration.loss_scale_m must be above 0 m";
  if (!(max_tilt_deg > 0 && max_tilt_deg <= 45)) {
    return "Georegistration.max_tilt_deg must be above 0 and at most 45 degrees";
  }
  if (!(level_roll_deg > 0 && level_roll_deg <= 45)) {
    return "Georegistration.level_roll_deg must be above 0 and at most 45 degrees";
  }
  if (ransac_samples < 1) return "Georegistration.ransac_samples must be at least 1";
  return "";
}

void BindOptions(OptionSet& set, GeoregistrationOptions* options) {
  set.Add("Georegistration", "max_residual_m", &options->max_residual_m,
          "photos further from their measured position are named and left out (m, > 0)");
  set.Add("Georegistration", "loss_scale_m", &options->loss_scale_m,
          "least residual that the robust loss discounts; twice the median if more (m, > 0)");
  set.Add("Georegistration", "max_tilt_deg", &options->max_tilt_deg,
          "largest uncertainty of the vertical (deg, 0 < t <= 45)");
  set.Add(
      "Georegistration", "level_roll_deg", &options->level_roll_deg,
      "roll that a level camera may have, used for one straight flight line (deg, 0 < r <= 45)");
  set.Add("Georegistration", "ransac_samples", &options->ransac_samples,
          "similarities tried (>= 1)");
  set.Add("Georegistration", "seed", &options->seed, "seed of the random samples");
}

GeoregistrationResult Georegister(const std::vector<MeasuredCamera>& cameras,
                                  const GeoregistrationOptions& options) {
  ThrowIfInvalid(options.Check());
  GeoregistrationResult result;
  if (cameras.size() < 3) {
    result.refusal = "only " + std::to_string(cameras.size()) +
                     " registered photos have a measured position; 3 are needed";
    return result;
  }
  const Observations observations = ObservationsOf(cameras);
  const double sigma_m = CommonSigma(cameras);
  Observations used;
  Fit(observations, false, sigma_m, options, &result, &used);
  if (result.world_from_model) {
    result.tilt_uncertainty_deg = TiltUncertaintyDeg(*result.world_from_model, used);
  }
  if (!result.world_from_model || result.tilt_uncertainty_deg > options.max_tilt_deg) {
    result.refusal.clear();
    Fit(observations, true, sigma_m, options, &result, &used);
    if (!result.world_from_model) return result;
    result.tilt_uncertainty_deg =
        std::min(TiltUncertaintyDeg(*result.world_from_model, used),
                 LevelTiltUncertaintyDeg(*result.world_from_model, used, options));
  }
  CheckCertainty(used, options, &result);
  if (result.world_from_model) ReportResiduals(cameras, options, &result);
  return result;
}

GeoregistrationResult ComparePositions(const std::vector<MeasuredCamera>& cameras,
                                       const GeoregistrationOptions& options) {
  ThrowIfInvalid(options.Check());
  GeoregistrationResult result;
  result.world_from_model = Sim3d();
  ReportResiduals(cameras, options, &result);
  return result;
}

}  // namespace colmap_ext
