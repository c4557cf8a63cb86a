#include "colmap_ext/eval/evaluate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"
#include "nearest.h"
#include "samples.h"

namespace colmap_ext {
namespace {

// What is judged: samples of both sides inside this box.
BoundingBox JudgedBox(const TriangleMesh& truth, const EvaluationOptions& options,
                      const std::optional<BoundingBox>& region) {
  BoundingBox box = BoundsOf(truth);
  const double ground_z = box.min().z() + options.ground_cut_m;
  box.min().array() -= options.margin_m;
  box.max().array() += options.margin_m;
  if (options.ground_cut_m > 0) box.min().z() = ground_z;
  return region ? box.intersection(*region) : box;
}

std::vector<Eigen::Vector3d> PositionsOf(const std::vector<SurfaceSample>& samples) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(samples.size());
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  return positions;
}

// Points of the model that are judged: samples of its surface, or its vertices when it is a cloud.
std::vector<Eigen::Vector3d> ModelPointsInBox(const TriangleMesh& model, const BoundingBox& box,
                                              const EvaluationOptions& options) {
  if (!model.faces.empty()) {
    return PositionsOf(SamplesInBox(model, box, options.sample_spacing_m, options.seed));
  }
  std::vector<Eigen::Vector3d> points;
  std::copy_if(model.vertices.begin(), model.vertices.end(), std::back_inserter(points),
               [&](const Eigen::Vector3d& vertex) { return box.contains(vertex); });
  return points;
}

double ShareBelow(const std::vector<double>& distances, double threshold) {
  if (distances.empty()) return 0;
  const auto below = std::count_if(distances.begin(), distances.end(),
                                   [&](double distance) { return distance < threshold; });
  return static_cast<double>(below) / static_cast<double>(distances.size());
}

double Mean(const std::vector<double>& values, double cap) {
  double sum = 0;
  for (const double value : values) sum += std::min(value, cap);
  return sum / static_cast<double>(values.size());
}

double Rms(const std::vector<double>& values, double cap) {
  double sum = 0;
  for (const double value : values) sum += std::min(value, cap) * std::min(value, cap);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

ErrorSummary Summarize(const std::vector<double>& errors, const EvaluationOptions& options) {
  const std::vector<double> thresholds = options.ThresholdsM();
  ErrorSummary summary;
  summary.samples = errors.size();
  for (const double threshold : thresholds) {
    summary.completeness.push_back(ShareBelow(errors, threshold));
  }
  if (errors.empty()) return summary;
  const double no_cap = std::numeric_limits<double>::infinity();
  summary.mean_m = Mean(errors, no_cap);
  summary.rms_m = Rms(errors, no_cap);
  summary.median_m = Quantile(errors, 0.5);
  summary.percentile90_m = Quantile(errors, 0.9);
  summary.capped_mean_m = Mean(errors, options.cap_m);
  summary.capped_rms_m = Rms(errors, options.cap_m);
  return summary;
}

std::vector<ThresholdScore> Scores(const EvaluationResult& result,
                                   const EvaluationOptions& options) {
  const std::vector<double> thresholds = options.ThresholdsM();
  std::vector<ThresholdScore> scores(thresholds.size());
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    ThresholdScore& score = scores[i];
    score.threshold_m = thresholds[i];
    score.completeness = result.errors.completeness[i];
    score.accuracy = ShareBelow(result.model_error_m, thresholds[i]);
    const double sum = score.completeness + score.accuracy;
    score.f_score = sum > 0 ? 2 * score.completeness * score.accuracy / sum : 0;
  }
  return scores;
}

}  // namespace

EvaluationResult EvaluateModel(const TriangleMesh& model, const TriangleMesh& truth,
                               const EvaluationOptions& options, const JobControl& job,
                               const std::optional<BoundingBox>& region) {
  ThrowIfInvalid(options.Check());
  if (truth.vertices.empty()) throw Error("evaluation: the ground truth is empty");
  if (model.vertices.empty()) throw Error("evaluation: the model is empty");
  const BoundingBox box = JudgedBox(truth, options, region);

  EvaluationResult result;
  result.truth_samples = SamplesInBox(truth, box, options.sample_spacing_m, options.seed);
  if (result.truth_samples.empty()) {
    throw Error(
        "evaluation: nothing of the ground truth is left to judge; check the region and "
        "ModelEvaluator.ground_cut_m");
  }
  job.ThrowIfCancelled();
  result.truth_error_m = NearestFinder(model, options.distance == "vertex")
                             .Distances(PositionsOf(result.truth_samples));
  job.Progress("evaluation", 1, 2);
  job.ThrowIfCancelled();
  result.model_samples = ModelPointsInBox(model, box, options);
  result.model_error_m = DistancesTo(truth, result.model_samples);
  job.Progress("evaluation", 2, 2);

  result.errors = Summarize(result.truth_error_m, options);
  result.scores = Scores(result, options);
  return result;
}

void SplitBySeen(const std::vector<int>& num_views, const EvaluationOptions& options,
                 EvaluationResult* result) {
  if (num_views.size() != result->truth_samples.size()) {
    throw Error("evaluation: views were counted for other samples than those of the result");
  }
  std::vector<double> seen;
  std::vector<double> unseen;
  for (std::size_t i = 0; i < num_views.size(); ++i) {
    (num_views[i] >= options.min_views ? seen : unseen).push_back(result->truth_error_m[i]);
  }
  result->seen = Summarize(seen, options);
  result->unseen = Summarize(unseen, options);
}

std::vector<double> DistancesTo(const TriangleMesh& truth,
                                const std::vector<Eigen::Vector3d>& points) {
  if (truth.vertices.empty()) throw Error("distances to the truth: it is empty");
  return NearestFinder(truth, false).Distances(points);
}

ModelAlignment AlignModel(const TriangleMesh& model, const TriangleMesh& truth,
                          const std::vector<CameraPair>& pairs, const EvaluationOptions& options,
                          const JobControl& job) {
  ModelAlignment alignment;
  if (!pairs.empty()) {
    alignment.cameras = AlignByCameras(pairs);
    alignment.truth_from_model = alignment.cameras->truth_from_model;
  }
  if (options.icp.max_iterations > 0) {
    IcpOptions icp = options.icp;
    if (alignment.cameras) icp.start_error_m = alignment.cameras->rms_m;
    alignment.icp = RefineByIcp(model, truth, alignment.truth_from_model, icp, job);
    alignment.truth_from_model = alignment.icp->truth_from_model;
  }
  return alignment;
}

}  // namespace colmap_ext
