#include "colmap_ext/eval/evaluate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "colmap_ext/geom/closest_point.h"
#include "colmap_ext/util/error.h"

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

std::vector<SurfaceSample> SamplesInBox(const TriangleMesh& mesh, const BoundingBox& box,
                                        const EvaluationOptions& options) {
  std::vector<bool> touches(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    BoundingBox face_box;
    for (int k = 0; k < 3; ++k) {
      face_box.extend(mesh.vertices[static_cast<std::size_t>(mesh.faces[i][k])]);
    }
    touches[i] = box.intersects(face_box);
  }
  std::vector<SurfaceSample> samples =
      SamplePoissonDisk(mesh, options.sample_spacing_m, options.seed, touches);
  std::erase_if(samples, [&](const SurfaceSample& s) { return !box.contains(s.position); });
  return samples;
}

// The index must not be empty.
std::vector<double> Distances(const std::vector<Eigen::Vector3d>& points,
                              const ClosestPointIndex& index) {
  std::vector<double> distances(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(),
                    [&](std::size_t i) { distances[i] = index.Find(points[i])->distance; });
  return distances;
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
  std::vector<Eigen::Vector3d> points;
  if (model.faces.empty()) {
    std::copy_if(model.vertices.begin(), model.vertices.end(), std::back_inserter(points),
                 [&](const Eigen::Vector3d& vertex) { return box.contains(vertex); });
  } else {
    points = PositionsOf(SamplesInBox(model, box, options));
  }
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

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

ThresholdScore Score(double threshold_m, const EvaluationResult& result) {
  ThresholdScore score;
  score.threshold_m = threshold_m;
  score.completeness = ShareBelow(result.truth_error_m, threshold_m);
  score.accuracy = ShareBelow(result.model_error_m, threshold_m);
  const double sum = score.completeness + score.accuracy;
  score.f_score = sum > 0 ? 2 * score.completeness * score.accuracy / sum : 0;
  return score;
}

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

}  // namespace

std::vector<double> EvaluationOptions::ThresholdsM() const {
  std::vector<double> thresholds;
  std::istringstream stream(thresholds_mm);
  for (std::string word; std::getline(stream, word, ',');) {
    double value = 0;
    char rest = 0;
    if (std::sscanf(word.c_str(), " %lf %c", &value, &rest) != 1 || !std::isfinite(value) ||
        value <= 0) {
      throw UsageError("ModelEvaluator.thresholds_mm: '" + word +
                       "' is no distance above 0; give millimetres separated by commas");
    }
    thresholds.push_back(value / 1000.0);
  }
  if (thresholds.empty()) throw UsageError("ModelEvaluator.thresholds_mm is empty");
  std::sort(thresholds.begin(), thresholds.end());
  return thresholds;
}

std::string EvaluationOptions::Check() const {
  const std::string section = "ModelEvaluator.";
  if (!(sample_spacing_m > 0)) return section + "sample_spacing_m must be above 0";
  if (distance != "surface" && distance != "vertex") {
    return section + "distance must be 'surface' or 'vertex', not '" + distance + "'";
  }
  if (!(cap_m > 0)) return section + "cap_m must be above 0";
  if (!(margin_m >= 0)) return section + "margin_m must not be negative";
  if (!(ground_cut_m >= 0)) return section + "ground_cut_m must not be negative";
  try {
    ThresholdsM();
  } catch (const UsageError& error) {
    return error.what();
  }
  const std::string icp_complaint = icp.Check();
  return icp_complaint.empty() ? "" : section + icp_complaint;
}

void BindOptions(OptionSet& set, EvaluationOptions* options) {
  const std::string section = "ModelEvaluator";
  set.Add(section, "sample_spacing_m", &options->sample_spacing_m,
          "distance between samples on both meshes (metres, > 0)");
  set.Add(section, "thresholds_mm", &options->thresholds_mm,
          "distances for completeness and accuracy (millimetres, > 0, separated by commas)");
  set.Add(section, "distance", &options->distance,
          "surface: nearest point of the model's triangles; vertex: nearest vertex, as the paper");
  set.Add(section, "cap_m", &options->cap_m,
          "larger errors count as this in the capped mean and RMS (metres, > 0)");
  set.Add(section, "margin_m", &options->margin_m,
          "the model is judged inside the truth's bounds grown by this (metres, >= 0)");
  set.Add(section, "ground_cut_m", &options->ground_cut_m,
          "nothing lower than this above the truth's lowest point is judged (metres, 0: off)");
  set.Add(section, "seed", &options->seed, "of the random samples");
  set.Add(section, "icp_iterations", &options->icp.max_iterations,
          "most steps of ICP (0: no ICP, … 10000)");
  set.Add(section, "icp_trim", &options->icp.trim,
          "share of the worst correspondences that ICP leaves out (0 … 0.9)");
  set.Add(section, "icp_max_distance_m", &options->icp.max_distance_m,
          "ICP leaves out correspondences further apart (metres, > 0)");
  set.Add(section, "icp_with_scale", &options->icp.with_scale,
          "ICP also estimates the scale (0/1)");
  set.Add(section, "icp_samples", &options->icp.num_samples,
          "points on the truth that ICP uses (100 … 10000000)");
}

EvaluationResult EvaluateModel(const TriangleMesh& model, const TriangleMesh& truth,
                               const EvaluationOptions& options, const JobControl& job,
                               const std::optional<BoundingBox>& region) {
  ThrowIfInvalid(options.Check());
  if (truth.faces.empty()) throw Error("evaluation: the ground truth has no faces");
  if (model.vertices.empty()) throw Error("evaluation: the model is empty");
  const bool to_vertices = options.distance == "vertex" || model.faces.empty();
  const BoundingBox box = JudgedBox(truth, options, region);

  EvaluationResult result;
  result.truth_samples = SamplesInBox(truth, box, options);
  if (result.truth_samples.empty()) {
    throw Error(
        "evaluation: nothing of the ground truth is left to judge; check the region and "
        "ModelEvaluator.ground_cut_m");
  }
  job.ThrowIfCancelled();
  const auto model_index = to_vertices ? ClosestPointIndex::OfPoints(model.vertices)
                                       : ClosestPointIndex::OfSurface(model);
  result.truth_error_m = Distances(PositionsOf(result.truth_samples), model_index);
  job.Progress("evaluation", 1, 2);
  job.ThrowIfCancelled();
  result.model_samples = ModelPointsInBox(model, box, options);
  result.model_error_m = DistancesToSurface(result.model_samples, truth);
  job.Progress("evaluation", 2, 2);

  const double no_cap = std::numeric_limits<double>::infinity();
  result.mean_error_m = Mean(result.truth_error_m, no_cap);
  result.rms_error_m = Rms(result.truth_error_m, no_cap);
  result.median_error_m = Median(result.truth_error_m);
  result.capped_mean_error_m = Mean(result.truth_error_m, options.cap_m);
  result.capped_rms_error_m = Rms(result.truth_error_m, options.cap_m);
  for (const double threshold_m : options.ThresholdsM()) {
    result.scores.push_back(Score(threshold_m, result));
  }
  return result;
}

std::vector<double> DistancesToSurface(const std::vector<Eigen::Vector3d>& points,
                                       const TriangleMesh& mesh) {
  if (mesh.faces.empty()) throw Error("distances to a surface: the mesh has no faces");
  return Distances(points, ClosestPointIndex::OfSurface(mesh));
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
    alignment.icp = RefineByIcp(model, truth, alignment.truth_from_model, options.icp, job);
    alignment.truth_from_model = alignment.icp->truth_from_model;
  }
  return alignment;
}

std::string ThresholdKey(double threshold_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%gmm", threshold_m * 1000.0);
  return text;
}

std::string EvaluationToJson(const EvaluationResult& result, const ModelAlignment& alignment,
                             const EvaluationOptions& options) {
  nlohmann::ordered_json json = {{"scale", alignment.truth_from_model.scale},
                                 {"mean_error_m", result.mean_error_m},
                                 {"rms_error_m", result.rms_error_m},
                                 {"median_error_m", result.median_error_m}};
  json["capped"] = {{"cap_m", options.cap_m},
                    {"mean_error_m", result.capped_mean_error_m},
                    {"rms_error_m", result.capped_rms_error_m}};
  for (const ThresholdScore& score : result.scores) {
    const std::string key = ThresholdKey(score.threshold_m);
    json["completeness"][key] = score.completeness;
    json["accuracy"][key] = score.accuracy;
    json["f_score"][key] = score.f_score;
  }
  json["samples"] = result.truth_samples.size();
  json["model_samples"] = result.model_samples.size();
  json["distance"] = options.distance;
  json["sample_spacing_m"] = options.sample_spacing_m;
  json["alignment"] = AlignmentJson(alignment);
  return json.dump(2) + "\n";
}

}  // namespace colmap_ext
