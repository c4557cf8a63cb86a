#include <nlohmann/json.hpp>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

nlohmann::ordered_json TransformJson(const Sim3d& b_from_a) {
  const Eigen::Quaterniond& q = b_from_a.rotation;
  const Eigen::Vector3d& t = b_from_a.translation;
  return {{"scale", b_from_a.scale},
          {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"translation_m", {t.x(), t.y(), t.z()}}};
}

nlohmann::ordered_json AlignmentJson(const ModelAlignment& alignment) {
  nlohmann::ordered_json json = {{"truth_from_model", TransformJson(alignment.truth_from_model)}};
  if (alignment.cameras) {
    json["cameras"] = {{"transform", TransformJson(alignment.cameras->truth_from_model)},
                       {"rms_m", alignment.cameras->rms_m},
                       {"rejected", alignment.cameras->rejected}};
  }
  if (alignment.icp) {
    json["icp"] = {{"transform", TransformJson(alignment.icp->truth_from_model)},
                   {"iterations", alignment.icp->iterations},
                   {"converged", alignment.icp->converged},
                   {"start_rms_m", alignment.icp->start_rms_m},
                   {"rms_m", alignment.icp->rms_m}};
  }
  return json;
}

// A part of the samples: {"share", "samples", "mean_error_m", …, "completeness": {…}}.
nlohmann::ordered_json PartJson(const ErrorSummary& part, const EvaluationResult& result) {
  nlohmann::ordered_json json = {{"share", static_cast<double>(part.samples) /
                                               static_cast<double>(result.truth_samples.size())},
                                 {"samples", part.samples},
                                 {"mean_error_m", part.mean_m},
                                 {"rms_error_m", part.rms_m},
                                 {"median_error_m", part.median_m},
                                 {"percentile90_error_m", part.percentile90_m}};
  for (std::size_t i = 0; i < result.scores.size(); ++i) {
    json["completeness"][ThresholdKey(result.scores[i].threshold_m)] = part.completeness[i];
  }
  return json;
}

}  // namespace

std::string ThresholdKey(double threshold_m) { return FormatNumber("%gmm", threshold_m * 1000.0); }

std::string EvaluationToJson(const EvaluationResult& result, const ModelAlignment& alignment,
                             const EvaluationOptions& options) {
  nlohmann::ordered_json json = {{"scale", alignment.truth_from_model.scale},
                                 {"mean_error_m", result.errors.mean_m},
                                 {"rms_error_m", result.errors.rms_m},
                                 {"median_error_m", result.errors.median_m},
                                 {"percentile90_error_m", result.errors.percentile90_m}};
  json["capped"] = {{"cap_m", options.cap_m},
                    {"mean_error_m", result.errors.capped_mean_m},
                    {"rms_error_m", result.errors.capped_rms_m}};
  for (const ThresholdScore& score : result.scores) {
    const std::string key = ThresholdKey(score.threshold_m);
    json["completeness"][key] = score.completeness;
    json["accuracy"][key] = score.accuracy;
    json["f_score"][key] = score.f_score;
  }
  if (result.seen) {
    json["seen"] = PartJson(*result.seen, result);
    json["seen"]["min_views"] = options.min_views;
  }
  if (result.unseen) json["unseen"] = PartJson(*result.unseen, result);
  json["samples"] = result.truth_samples.size();
  json["model_samples"] = result.model_samples.size();
  json["distance"] = options.distance;
  json["sample_spacing_m"] = options.sample_spacing_m;
  json["alignment"] = AlignmentJson(alignment);
  return json.dump(2) + "\n";
}

}  // namespace colmap_ext
