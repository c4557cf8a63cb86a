#include "calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace colmap_ext {
namespace {

constexpr std::array<double, 8> kThresholdsPx = {0.1, 0.2, 0.4, 0.7, 1.1, 1.7, 2.6, 4.0};
constexpr int kNumUnknowns = 5;  // constant, stereo, support, views, steepness
using Row = Eigen::Matrix<double, kNumUnknowns, 1>;

struct Observation {
  double log_stereo = 0, log_support = 0, log_views = 0, log_error = 0;  // of pixels
  double weight = 0;
};

std::vector<Observation> ObservationsOf(const std::vector<JudgedFlight>& flights,
                                        const ErrorModel& model) {
  std::vector<Observation> observations;
  for (const JudgedFlight& flight : flights) {
    for (const JudgedPoint& point : flight.points) {
      const ErrorCues& cues = point.cues;
      if (cues.num_views < 1 || !(cues.pixel_mm > 0)) continue;
      const double stereo_px = cues.stereo_mm < 0
                                   ? model.max_stereo_px
                                   : std::min(model.max_stereo_px, cues.stereo_mm / cues.pixel_mm);
      const double support_px =
          std::clamp(cues.support_mm / cues.pixel_mm, model.min_support_px, model.max_support_px);
      observations.push_back({std::log(stereo_px), std::log(support_px),
                              std::log(cues.num_views + 1.0),
                              std::log(1000 * point.true_error_m / cues.pixel_mm + 1e-6),
                              100 / static_cast<double>(flight.points.size())});
    }
  }
  return observations;
}

// What keeps a view more from ever being harmful.
struct Bounds {
  bool sum_is_one = false;  // the support's exponent is what the stereo's leaves of 1
  bool no_views = false;    // the exponent of the views is 0
};

// Columns so that row · unknowns > 0 says "more than t".
Row RowOf(const Observation& o, double log_t, const Bounds& bounds) {
  const double views = bounds.no_views ? 0.0 : -o.log_views;
  Row row;
  if (bounds.sum_is_one) {
    row << 1, o.log_stereo - o.log_support, 0, views, o.log_support - log_t;
  } else {
    row << 1, o.log_stereo, o.log_support, views, -log_t;
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
  fitted.support_exponent = unknowns[2] / unknowns[4];
  fitted.views_exponent = unknowns[3] / unknowns[4];
  return fitted;
}

void ReportErrorModel(const std::string& name, const ErrorModel& model, BenchReport* report) {
  report->Add(name + ": scale", model.scale, "");
  report->Add(name + ": stereo_exponent", model.stereo_exponent, "");
  report->Add(name + ": support_exponent", model.support_exponent, "");
  report->Add(name + ": views_exponent", model.views_exponent, "");
  report->Add(name + ": steepness", model.steepness, "");
}

}  // namespace colmap_ext
