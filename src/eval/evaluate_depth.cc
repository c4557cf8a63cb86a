#include "colmap_ext/eval/evaluate_depth.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kConfidenceBins = 10;

void RequireSameSize(const std::string& name, const DenseMap& truth, const DenseMap& other,
                     const std::string& what) {
  if (other.channels == 1 && other.width == truth.width && other.height == truth.height) return;
  throw Error(name + ": the " + what + " has " + std::to_string(other.width) + " x " +
              std::to_string(other.height) + " pixels and " + std::to_string(other.channels) +
              " channels, the true depth " + std::to_string(truth.width) + " x " +
              std::to_string(truth.height) + "; render the truth at that size");
}

double Mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

// `sorted` ascending; 0 when empty.
double Percentile(const std::vector<float>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(sorted.size()));
  return static_cast<double>(sorted[std::min(rank, sorted.size() - 1)]);
}

double ShareBelow(const std::vector<float>& sorted, float limit) {
  if (sorted.empty()) return 0;
  const auto end = std::lower_bound(sorted.begin(), sorted.end(), limit);
  return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size());
}

std::vector<ConfidenceBin> Bins(const std::vector<float>& errors,
                                const std::vector<float>& confidence) {
  std::vector<std::vector<float>> errors_of_bin(kConfidenceBins);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto bin = static_cast<std::size_t>(confidence[i] * static_cast<float>(kConfidenceBins));
    errors_of_bin[std::min(bin, kConfidenceBins - 1)].push_back(errors[i]);
  }
  std::vector<ConfidenceBin> bins;
  for (std::size_t i = 0; i < kConfidenceBins; ++i) {
    std::sort(errors_of_bin[i].begin(), errors_of_bin[i].end());
    const double width = 1.0 / static_cast<double>(kConfidenceBins);
    bins.push_back({static_cast<double>(i) * width, static_cast<double>(i + 1) * width,
                    errors_of_bin[i].size(), Mean(errors_of_bin[i]),
                    Percentile(errors_of_bin[i], 0.5)});
  }
  return bins;
}

}  // namespace

void DepthEvaluator::Add(const std::string& name, const DenseMap& depth, const DenseMap& truth,
                         const DenseMap* confidence) {
  RequireSameSize(name, truth, truth, "true depth");
  RequireSameSize(name, truth, depth, "depth map");
  if (confidence != nullptr) RequireSameSize(name, truth, *confidence, "confidence map");
  const bool is_first = truth_pixels_ == 0 && false_pixels_ == 0;
  if (!is_first && has_confidence_ != (confidence != nullptr)) {
    throw Error(name + ": some depth maps have a confidence map and some have none");
  }
  has_confidence_ = confidence != nullptr;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    const float z = depth.data[i];
    const float true_z = truth.data[i];
    const bool has_depth = z > 0 && std::isfinite(z);
    if (!(true_z > 0) || !std::isfinite(true_z)) {
      false_pixels_ += has_depth ? 1 : 0;
      continue;
    }
    ++truth_pixels_;
    if (!has_depth) continue;
    relative_error_.push_back(std::abs(z - true_z) / true_z);
    sum_error_m_ += static_cast<double>(std::abs(z - true_z));
    if (has_confidence_) confidence_.push_back(std::clamp(confidence->data[i], 0.0f, 1.0f));
  }
}

DepthEvaluation DepthEvaluator::Result() const {
  if (truth_pixels_ == 0) throw Error("depth evaluation: the true depth maps show no surface");
  DepthEvaluation result;
  result.truth_pixels = truth_pixels_;
  result.valid_pixels = relative_error_.size();
  result.false_pixels = false_pixels_;
  result.valid_share =
      static_cast<double>(result.valid_pixels) / static_cast<double>(truth_pixels_);
  result.mean = Mean(relative_error_);
  if (result.valid_pixels > 0) {
    result.mean_error_m = sum_error_m_ / static_cast<double>(result.valid_pixels);
  }
  if (has_confidence_) result.by_confidence = Bins(relative_error_, confidence_);
  std::vector<float> sorted = relative_error_;
  std::sort(sorted.begin(), sorted.end());
  result.median = Percentile(sorted, 0.5);
  result.percentile90 = Percentile(sorted, 0.9);
  result.percentile99 = Percentile(sorted, 0.99);
  result.within_1_percent = ShareBelow(sorted, 0.01f);
  result.within_5_percent = ShareBelow(sorted, 0.05f);
  return result;
}

std::string DepthEvaluationToJson(const DepthEvaluation& evaluation) {
  nlohmann::ordered_json json = {{"truth_pixels", evaluation.truth_pixels},
                                 {"valid_pixels", evaluation.valid_pixels},
                                 {"false_pixels", evaluation.false_pixels},
                                 {"valid_share", evaluation.valid_share},
                                 {"mean_error_m", evaluation.mean_error_m}};
  json["relative_error"] = {{"mean", evaluation.mean},
                            {"median", evaluation.median},
                            {"percentile90", evaluation.percentile90},
                            {"percentile99", evaluation.percentile99},
                            {"within_1_percent", evaluation.within_1_percent},
                            {"within_5_percent", evaluation.within_5_percent}};
  for (const ConfidenceBin& bin : evaluation.by_confidence) {
    json["by_confidence"].push_back({{"low", bin.low},
                                     {"high", bin.high},
                                     {"pixels", bin.pixels},
                                     {"mean", bin.mean},
                                     {"median", bin.median}});
  }
  return json.dump(2) + "\n";
}

}  // namespace colmap_ext
