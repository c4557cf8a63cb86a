#include "calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace colmap_ext {
namespace {

constexpr std::array<double, 8> kThresholdsPx = {0.1, 0.2, 0.4, 0.7, 1.1, 1.7, 2.6, 4.0};
constexpr int kNumUnknowns = 5;  // constant, stereo, scatter, views, steepness
using Row = Eigen::Matrix<double, kNumUnknowns, 1>;

struct Observation {
  CueLogs logs;
  double log_error = 0;  // of pixels
  double weight = 0;
};

std::vector<Observation> ObservationsOf(const std::vector<JudgedFlight>& flights,
                                        const ErrorModel& model) {
  std::vector<Observation> observations;
  for (const JudgedFlight& flight : flights) {
    for (const JudgedPoint& point : flight.points) {
      const ErrorCues& cues = point.cues;
      if (cues.num_views < 1 || !(cues.pixel_mm > 0)) continue;
      observations.push_back({LogsOf(cues, model),
                              std::log(1000 * point.true_error_m / cues.pixel_mm + 1e-6),
                              100 / static_cast<double>(flight.points.size())});
    }
  }
  return observations;
}

// What keeps a view more from ever being harmful.
struct Bounds {
  bool sum_is_one = false;  // the scatter's exponent is what the stereo's leaves of 1
  bool no_views = false;    // the exponent of the views is 0
};

// Columns so that row · unknowns > 0 says "more than t".
Row RowOf(const Observation& o, double log_t, const Bounds& bounds) {
  const double views = bounds.no_views ? 0.0 : -o.logs.views;
  Row row;
  if (bounds.sum_is_one) {
    row << 1, o.logs.stereo - o.logs.scatter, 0, views, o.logs.scatter - log_t;
  } else {
    row << 1, o.logs.stereo, o.logs.scatter, views, -log_t;
  }
  return row;
}

// Newton's method on the (convex) negative log-likelihood.
Row FitLogistic(const std::vector<Observation>& observations, const Bounds& bounds) {
  constexpr int kIterations = 25;
  constexpr double kRidge = 1e-6;
  Row unknowns = Row::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix<double, kNumUnknowns, kNumUnknowns> hessian =
        kRidge * Eigen::Matrix<double, kNumUnknowns, kNumUnknowns>::Identity();
    Row gradient = -kRidge * unknowns;
    for (const Observation& o : observations) {
      for (const double t : kThresholdsPx) {
        const Row row = RowOf(o, std::log(t), bounds);
        const double p = 1 / (1 + std::exp(-std::clamp(row.dot(unknowns), -30.0, 30.0)));
        const double y = o.log_error > std::log(t) ? 1 : 0;
        gradient += o.weight * (y - p) * row;
        hessian += (o.weight * p * (1 - p) + 1e-12) * row * row.transpose();
      }
    }
    unknowns += hessian.ldlt().solve(gradient);
  }
  return unknowns;
}

// The constants of "the final model is not there", unknowns that would be negative held at 0.
void FitFailure(const std::vector<JudgedFlight>& flights, ErrorModel* model) {
  constexpr double kFailurePx = 6;  // more than any noise of matching
  constexpr int kIterations = 40;
  constexpr double kRidge = 1e-3;
  Eigen::Vector4d unknowns = Eigen::Vector4d::Zero();
  Eigen::Array4d is_free = Eigen::Array4d::Ones();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix4d hessian = kRidge * Eigen::Matrix4d::Identity();
    Eigen::Vector4d gradient = -kRidge * unknowns;
    for (const JudgedFlight& flight : flights) {
      const double weight = 100 / static_cast<double>(flight.points.size());
      for (const JudgedPoint& point : flight.points) {
        if (!(point.cues.pixel_mm > 0)) continue;
        const CueLogs& logs = point.around;
        const Eigen::Vector4d row =
            Eigen::Array4d(1, logs.stereo, logs.scatter, -logs.views) * is_free;
        const double p = 1 / (1 + std::exp(-std::clamp(row.dot(unknowns), -30.0, 30.0)));
        const double y = 1000 * point.true_error_m > kFailurePx * point.cues.pixel_mm ? 1 : 0;
        gradient += weight * (y - p) * row;
        hessian += (weight * p * (1 - p) + 1e-12) * row * row.transpose();
      }
    }
    unknowns += hessian.ldlt().solve(gradient);
    for (int k = 1; iteration == kIterations / 2 && k < 4; ++k) {
      if (unknowns[k] < 0) is_free[k] = unknowns[k] = 0;
    }
  }
  model->failure_constant = unknowns[0];
  model->failure_stereo = std::max(0.0, unknowns[1]);
  model->failure_scatter = std::max(0.0, unknowns[2]);
  model->failure_views = std::max(0.0, unknowns[3]);
}

}  // namespace

ErrorModel FitErrorModel(const std::vector<JudgedFlight>& flights, const ErrorModel& model) {
  const std::vector<Observation> observations = ObservationsOf(flights, model);
  Bounds bounds;
  Row unknowns = FitLogistic(observations, bounds);
  if (unknowns[3] < 0) {
    bounds.no_views = true;
    unknowns = FitLogistic(observations, bounds);
  }
  if (unknowns[1] + unknowns[2] > unknowns[4]) {
    bounds.sum_is_one = true;
    unknowns = FitLogistic(observations, bounds);
    unknowns[2] = unknowns[4] - unknowns[1];
  }
  ErrorModel fitted = model;
  fitted.steepness = unknowns[4];
  fitted.scale = std::exp(unknowns[0] / unknowns[4]);
  fitted.stereo_exponent = unknowns[1] / unknowns[4];
  fitted.scatter_exponent = unknowns[2] / unknowns[4];
  fitted.views_exponent = unknowns[3] / unknowns[4];
  FitFailure(flights, &fitted);
  return fitted;
}

void ReportErrorModel(const std::string& name, const ErrorModel& model, BenchReport* report) {
  report->Add(name + ": scale", model.scale, "");
  report->Add(name + ": stereo_exponent", model.stereo_exponent, "");
  report->Add(name + ": scatter_exponent", model.scatter_exponent, "");
  report->Add(name + ": views_exponent", model.views_exponent, "");
  report->Add(name + ": steepness", model.steepness, "");
  report->Add(name + ": failure_constant", model.failure_constant, "");
  report->Add(name + ": failure_stereo", model.failure_stereo, "");
  report->Add(name + ": failure_scatter", model.failure_scatter, "");
  report->Add(name + ": failure_views", model.failure_views, "");
}

}  // namespace colmap_ext
