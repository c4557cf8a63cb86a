// How well a score tells bad points from good ones.
#pragma once

#include <optional>
#include <vector>

namespace colmap_ext {

// Probability that a bad point has the higher score than a good one (ties: half), 0 … 1: the area
// under the ROC curve. 0.5 when one of the kinds is missing.
double AreaUnderCurve(const std::vector<double>& score, const std::vector<bool>& is_bad);

struct PrecisionRecall {
  double precision = 0;  // share of the flagged ones that are bad; 1 when none is flagged
  double recall = 0;     // share of the bad ones that are flagged; 1 when none is bad
  double F1() const;
};
PrecisionRecall MeasureFlags(const std::vector<bool>& is_flagged, const std::vector<bool>& is_bad);

// The threshold on the score ("at least": flagged) with the best F1, which a rule without a natural
// threshold is given.
PrecisionRecall BestFlags(const std::vector<double>& score, const std::vector<bool>& is_bad);

// Spearman's rank correlation, -1 … 1 (ties get their mean rank).
double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b);

// One bin of the calibration curve.
struct CalibrationBin {
  double low = 0, high = 0;  // of the prediction
  std::size_t points = 0;
  double predicted = 0;  // median
  double measured = 0;   // median
};
// Bins at `edges` (ascending).
std::vector<CalibrationBin> CalibrationCurve(const std::vector<double>& predicted,
                                             const std::vector<double>& measured,
                                             const std::vector<double>& edges);

}  // namespace colmap_ext
