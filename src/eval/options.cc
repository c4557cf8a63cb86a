#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

// "1in", "25.4 mm", "25.4" to metres; nullopt for anything else.
std::optional<double> ParseDistance(const std::string& word) {
  static const std::map<std::string, double> kMetersOfUnit = {
      {"", 1e-3}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}};
  std::istringstream stream(word);
  double value = 0;
  std::string unit;
  std::string rest;
  if (!(stream >> value) || !std::isfinite(value) || value <= 0) return std::nullopt;
  stream >> unit >> rest;
  const auto found = kMetersOfUnit.find(unit);
  if (found == kMetersOfUnit.end() || !rest.empty()) return std::nullopt;
  return value * found->second;
}

}  // namespace

std::vector<double> EvaluationOptions::ThresholdsM() const {
  std::vector<double> parsed;
  for (const std::string& word : SplitAtCommas(thresholds)) {
    const auto distance_m = ParseDistance(word);
    if (!distance_m) {
      throw UsageError("ModelEvaluator.thresholds: '" + word +
                       "' is no distance above 0; give numbers with mm, cm, m or in, separated "
                       "by commas");
    }
    parsed.push_back(*distance_m);
  }
  if (parsed.empty()) throw UsageError("ModelEvaluator.thresholds is empty");
  std::sort(parsed.begin(), parsed.end());
  return parsed;
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
  if (min_views < 1) return section + "min_views must be at least 1";
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
  set.Add(section, "thresholds", &options->thresholds,
          "distances for completeness and accuracy, with mm, cm, m or in, separated by commas");
  set.Add(section, "distance", &options->distance,
          "surface: nearest point of the model's triangles; vertex: nearest vertex, as the paper");
  set.Add(section, "cap_m", &options->cap_m,
          "larger errors count as this in the capped mean and RMS (metres, > 0)");
  set.Add(section, "margin_m", &options->margin_m,
          "the model is judged inside the truth's bounds grown by this (metres, >= 0)");
  set.Add(section, "ground_cut_m", &options->ground_cut_m,
          "nothing lower than this above the truth's lowest point is judged (metres, 0: off)");
  set.Add(section, "min_views", &options->min_views,
          "a surface counts as seen when so many photos of the sparse model see it (>= 1)");
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

}  // namespace colmap_ext
