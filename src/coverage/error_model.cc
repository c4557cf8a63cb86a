#include "colmap_ext/coverage/error_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {

double TriangulationError(const ViewOfPoint& first, const ViewOfPoint& second, double sigma_px) {
  const double squared_s1 = sigma_px * sigma_px / first.projection_ratio;
  const double squared_s2 = sigma_px * sigma_px / second.projection_ratio;
  const double squared_sin = first.direction.cross(second.direction).squaredNorm();
  const double sum = squared_s1 + squared_s2;
  return std::sqrt(sum / squared_sin + squared_s1 * squared_s2 / sum);
}

double PredictedError(const std::vector<ViewOfPoint>& views, double sigma_px,
                      double max_angle_rad) {
  const double min_cos = std::cos(max_angle_rad);
  const double max_sin = max_angle_rad < std::numbers::pi / 2 ? std::sin(max_angle_rad) : 1.0;
  // Sharpest views first: no pair is better than both views are sharp (at the best angle), so most
  // of the pairs of hundreds of views need no look.
  std::vector<const ViewOfPoint*> sharpest;
  for (const ViewOfPoint& view : views) sharpest.push_back(&view);
  std::sort(sharpest.begin(), sharpest.end(), [](const ViewOfPoint* a, const ViewOfPoint* b) {
    return a->projection_ratio > b->projection_ratio;
  });
  const auto least = [&](std::size_t i, std::size_t j) {
    const double squared_s1 = sigma_px * sigma_px / sharpest[i]->projection_ratio;
    const double squared_s2 = sigma_px * sigma_px / sharpest[j]->projection_ratio;
    const double sum = squared_s1 + squared_s2;
    constexpr double kRounding = 1 - 1e-9;
    return kRounding * std::sqrt(sum / (max_sin * max_sin) + squared_s1 * squared_s2 / sum);
  };
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < sharpest.size(); ++i) {
    if (least(i, i + 1) >= smallest) break;
    for (std::size_t j = i + 1; j < sharpest.size(); ++j) {
      if (least(i, j) >= smallest) break;
      if (sharpest[i]->direction.dot(sharpest[j]->direction) < min_cos) continue;
      smallest = std::min(smallest, TriangulationError(*sharpest[i], *sharpest[j], sigma_px));
    }
  }
  return std::isfinite(smallest) ? smallest : -1.0;
}

ErrorCues CuesOf(const std::vector<ViewOfPoint>& views, double scatter_m, double max_angle_rad) {
  ErrorCues cues;
  cues.num_views = static_cast<int>(views.size());
  cues.scatter_mm = 1000 * scatter_m;
  double best_ratio = 0;
  for (const ViewOfPoint& view : views) best_ratio = std::max(best_ratio, view.projection_ratio);
  if (best_ratio > 0) cues.pixel_mm = 1000 / std::sqrt(best_ratio);
  const double stereo_m = PredictedError(views, 1.0, max_angle_rad);
  if (stereo_m >= 0) cues.stereo_mm = 1000 * stereo_m;
  return cues;
}

CueLogs LogsOf(const ErrorCues& cues, const ErrorModel& model) {
  const bool is_seen = cues.num_views > 0 && cues.pixel_mm > 0;
  const double stereo_px = !is_seen || cues.stereo_mm < 0
                               ? model.max_stereo_px
                               : std::min(model.max_stereo_px, cues.stereo_mm / cues.pixel_mm);
  const double scatter_px =
      is_seen && cues.scatter_mm > 0
          ? std::clamp(cues.scatter_mm / cues.pixel_mm, model.min_scatter_px, model.max_scatter_px)
          : model.typical_scatter_px;
  return {std::log(stereo_px), std::log(scatter_px), std::log(cues.num_views + 1.0)};
}

double PredictErrorMm(const ErrorCues& cues, const ErrorModel& model) {
  if (cues.num_views < 1 || !(cues.pixel_mm > 0)) return -1;
  const CueLogs logs = LogsOf(cues, model);
  return cues.pixel_mm * model.scale *
         std::exp(model.stereo_exponent * logs.stereo + model.scatter_exponent * logs.scatter -
                  model.views_exponent * logs.views);
}

std::vector<CueLogs> MeanLogsAround(const std::vector<Eigen::Vector3d>& positions,
                                    const std::vector<CueLogs>& logs, int neighbors) {
  std::vector<CueLogs> means(positions.size());
  if (positions.empty()) return means;
  const PointIndex index(positions);
  ParallelFor(positions.size(), [&](std::size_t i) {
    const auto around = index.NearestOf(positions[i], static_cast<std::size_t>(neighbors));
    const double share = 1 / static_cast<double>(around.size());
    for (const PointNeighbor& neighbor : around) {
      const CueLogs& other = logs[static_cast<std::size_t>(neighbor.index)];
      means[i].stereo += share * other.stereo;
      means[i].scatter += share * other.scatter;
      means[i].views += share * other.views;
    }
  });
  return means;
}

double FailureProbability(const CueLogs& around, const ErrorModel& model) {
  const double f = model.failure_constant + model.failure_stereo * around.stereo +
                   model.failure_scatter * around.scatter - model.failure_views * around.views;
  return 1 / (1 + std::exp(-f));
}

double ProbabilityWithin(double target_mm, double predicted_mm, double failure,
                         const ErrorModel& model) {
  if (predicted_mm < 0) return 0;
  return (1 - failure) / (1 + std::pow(predicted_mm / target_mm, model.steepness));
}

std::string ErrorModel::Check() const {
  const std::string prefix = "ErrorModel.";
  if (!(scale > 0)) return prefix + "scale must be above 0";
  if (!(stereo_exponent >= 0 && scatter_exponent >= 0 && stereo_exponent + scatter_exponent <= 1)) {
    return prefix + "stereo_exponent and scatter_exponent must be >= 0, together at most 1";
  }
  if (!(views_exponent >= 0)) return prefix + "views_exponent must be >= 0";
  if (!(steepness > 0)) return prefix + "steepness must be above 0";
  if (!std::isfinite(failure_constant)) return prefix + "failure_constant must be a number";
  if (!(failure_stereo >= 0 && failure_scatter >= 0 && failure_views >= 0)) {
    return prefix + "failure_stereo, failure_scatter and failure_views must be >= 0";
  }
  if (neighbors < 1 || neighbors > 1000) return prefix + "neighbors must be in 1 … 1000";
  if (!(max_angle_deg > 0 && max_angle_deg <= 180)) {
    return prefix + "max_angle_deg must be in (0, 180]";
  }
  if (!(max_stereo_px > 0 && min_scatter_px > 0 && typical_scatter_px > 0)) {
    return prefix + "max_stereo_px, min_scatter_px and typical_scatter_px must be above 0";
  }
  if (!(max_scatter_px >= min_scatter_px)) {
    return prefix + "max_scatter_px must be at least min_scatter_px";
  }
  return "";
}

void BindOptions(OptionSet& set, ErrorModel* model) {
  const std::string section = "ErrorModel";
  set.Add(section, "scale", &model->scale,
          "predicted error in pixels of the best view where stereo and scatter are one pixel; half "
          "of it for a final model from photos of twice the width");
  set.Add(section, "stereo_exponent", &model->stereo_exponent,
          "how the error grows with that of the best pair of views, >= 0");
  set.Add(section, "scatter_exponent", &model->scatter_exponent,
          "how the error grows with the scatter of the points of the fast stereo, >= 0");
  set.Add(section, "views_exponent", &model->views_exponent,
          "how the error falls with the number of views, >= 0");
  set.Add(section, "steepness", &model->steepness,
          "of the probability that the error is within the target, > 0");
  set.Add(section, "failure_constant", &model->failure_constant,
          "log-odds that the final model fails where stereo and scatter are one pixel");
  set.Add(section, "failure_stereo", &model->failure_stereo,
          "how these grow with the logarithm of the error of the best pair of views, >= 0");
  set.Add(section, "failure_scatter", &model->failure_scatter,
          "how these grow with the logarithm of the scatter of the points, >= 0");
  set.Add(section, "failure_views", &model->failure_views,
          "how these fall with the logarithm of the number of views + 1, >= 0");
  set.Add(section, "neighbors", &model->neighbors,
          "iso-points over which these logarithms are averaged (1 … 1000)");
  set.Add(section, "max_angle_deg", &model->max_angle_deg,
          "largest angle of a pair of views, degrees");
  set.Add(section, "max_stereo_px", &model->max_stereo_px,
          "error of a pair counts as so many pixels at most, and without a pair");
  set.Add(section, "min_scatter_px", &model->min_scatter_px,
          "scatter of the points counts as so many pixels at least");
  set.Add(section, "max_scatter_px", &model->max_scatter_px,
          "scatter of the points counts as so many pixels at most");
  set.Add(section, "typical_scatter_px", &model->typical_scatter_px,
          "scatter of the points in pixels where it is not known (a mesh of unknown origin)");
}

}  // namespace colmap_ext
