// How wrong the final model will be at a place: a prediction from what the photos see of it and
// from what the fast stereo found there, calibrated in simulation.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

// One photo's view of an iso-point.
struct ViewOfPoint {
  Eigen::Vector3d direction;    // unit, from the point to the camera; world
  double projection_ratio = 0;  // γ, px² / m²; > 0
};

// Predicted standard deviation (metres, length of the error vector) of a point triangulated from
// two views whose rays meet at the angle α:
//
//   e² = (s1² + s2²) / sin²α + s1² s2² / (s1² + s2²),   s = sigma_px / sqrt(γ)
//
// s is what sigma_px pixels cover on the surface, slant included. e² is the trace of the inverse of
// Σ (I − d dᵀ) / s², the information of two rays that each fix the point across their direction d.
// Infinite for parallel rays.
double TriangulationError(const ViewOfPoint& first, const ViewOfPoint& second, double sigma_px);

// The smallest TriangulationError of the pairs of `views` whose angle is at most max_angle_rad
// (beyond it matching fails); -1 without such a pair. Views more never make it worse.
double PredictedError(const std::vector<ViewOfPoint>& views, double sigma_px, double max_angle_rad);

// What the prediction is made from.
struct ErrorCues {
  int num_views = 0;    // that see the place
  double pixel_mm = 0;  // what a pixel covers there in the best view, slant included: 1000/sqrt(γ)
  double stereo_mm = -1;  // of the best pair for matches that err by 1 px; -1: no pair
  // How far the points of the fast stereo lie from its surface (Surface::scatter_m); 0: unknown.
  double scatter_mm = 0;
};
// `max_angle_rad`: of a pair. `scatter_m`: 0 when it is not known.
ErrorCues CuesOf(const std::vector<ViewOfPoint>& views, double scatter_m, double max_angle_rad);

// Two things can go wrong at a place. The final model can be there and err; the median of that
// error, in pixels p of the best view, is
//
//   ê / p = scale · (stereo / p)^a · (scatter / p)^b · (num_views + 1)^−c
//
// and the probability that it is at most t: 1 / (1 + (ê / t)^κ). stereo / p counts as
// max_stereo_px at most, also for a place without a pair; scatter / p as min_ … max_scatter_px, and
// typical_scatter_px where it is unknown. As a, b, c >= 0 and a + b <= 1, a view more never makes
// it worse.
//
// Or the final model can fail there: have no surface, or one elsewhere. The probability of that is
//
//   1 / (1 + exp(−f)),  f = failure_constant + failure_stereo · ln(stereo / p)
//                           + failure_scatter · ln(scatter / p) − failure_views · ln(num_views + 1)
//
// with the mean of each logarithm over the place and its surroundings (`neighbors` iso-points), for
// matching windows and the final surface mix neighbours.
//
// The constants are those that predict the errors of the built-in dense reconstruction best
// (logistic regressions: ê over eight thresholds from 0.1 to 4 px at once, f for 6 px;
// docs/algorithms.md, "Predicted error", names the flights). `bench_coverage --calibrate 1` fits
// them anew.
struct ErrorModel {
  double scale = 0.314;             // > 0
  double stereo_exponent = 0.30;    // a, >= 0
  double scatter_exponent = 0.363;  // b, >= 0; a + b <= 1
  double views_exponent = 0.153;    // c, >= 0
  double steepness = 1.652;         // κ, > 0
  double failure_constant = -2.7;
  double failure_stereo = 0.25;     // >= 0
  double failure_scatter = 1.04;    // >= 0
  double failure_views = 1.5;       // >= 0
  int neighbors = 15;               // iso-points, itself among them, 1 … 1000
  double max_angle_deg = 40;        // of a pair, (0, 180]; DenseStereo.max_angle_deg
  double max_stereo_px = 33;        // > 0
  double min_scatter_px = 0.1;      // > 0
  double max_scatter_px = 100;      // >= min_scatter_px
  double typical_scatter_px = 1.1;  // > 0; the median of flights that are dense enough

  std::string Check() const;
};

// Section "ErrorModel".
void BindOptions(OptionSet& set, ErrorModel* model);

// ê in millimetres; -1 when no photo sees the place.
double PredictErrorMm(const ErrorCues& cues, const ErrorModel& model);

// Natural logarithms of the cues as both equations take them: bounded, in pixels of the best view.
struct CueLogs {
  double stereo = 0;
  double scatter = 0;
  double views = 0;  // of num_views + 1
};
CueLogs LogsOf(const ErrorCues& cues, const ErrorModel& model);

// The mean of each logarithm over the `neighbors` nearest positions, itself among them. One entry a
// position.
std::vector<CueLogs> MeanLogsAround(const std::vector<Eigen::Vector3d>& positions,
                                    const std::vector<CueLogs>& logs, int neighbors);

// Probability that the final model fails where these are the means (MeanLogsAround).
double FailureProbability(const CueLogs& around, const ErrorModel& model);

// Probability that the final model is there and errs by at most `target_mm` (> 0), where
// `predicted_mm` is predicted and it fails with `failure`; 0 for a negative prediction.
double ProbabilityWithin(double target_mm, double predicted_mm, double failure,
                         const ErrorModel& model);

}  // namespace colmap_ext
