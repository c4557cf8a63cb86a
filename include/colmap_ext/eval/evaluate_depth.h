// How far depth maps are from the truth.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/scene/dense_map.h"

namespace colmap_ext {

// Pixels whose confidence lies in [low, high) (the last bin includes its end).
struct ConfidenceBin {
  double low = 0;
  double high = 0;
  std::size_t pixels = 0;
  double mean = 0;    // of |Δz| / z; 0 without pixels
  double median = 0;  // ...
};

// Shares between 0 and 1; errors are |Δz| / z, z the true depth.
struct DepthEvaluation {
  std::size_t truth_pixels = 0;  // pixels where the truth has a surface
  std::size_t valid_pixels = 0;  // ... and the map a depth
  std::size_t false_pixels = 0;  // the map has a depth where the truth has none
  double valid_share = 0;
  double mean = 0;
  double median = 0;
  double percentile90 = 0;
  double percentile99 = 0;
  double within_1_percent = 0;  // share of the valid pixels
  double within_5_percent = 0;
  double mean_error_m = 0;                   // |Δz|
  std::vector<ConfidenceBin> by_confidence;  // ten bins over 0 … 1; empty without confidence
};

// Collects pixels map by map. A depth <= 0 is none.
class DepthEvaluator {
 public:
  // `confidence` may be null; values outside 0 … 1 are clamped. `name`: for errors. Throws Error
  // when sizes differ, a map has more than one channel, or a map comes without confidence after
  // others with it.
  void Add(const std::string& name, const DenseMap& depth, const DenseMap& truth,
           const DenseMap* confidence);

  // Throws Error when no pixel of the truth has a surface.
  DepthEvaluation Result() const;

 private:
  std::size_t truth_pixels_ = 0;
  std::size_t false_pixels_ = 0;
  double sum_error_m_ = 0;
  std::vector<float> relative_error_;
  std::vector<float> confidence_;
  bool has_confidence_ = false;
};

std::string DepthEvaluationToJson(const DepthEvaluation& evaluation);

}  // namespace colmap_ext
