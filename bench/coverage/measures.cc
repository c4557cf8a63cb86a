#include "measures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace colmap_ext {
namespace {

std::vector<std::size_t> Ascending(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

// Ranks from 1, ties with their mean.
std::vector<double> Ranks(const std::vector<double>& values) {
  const std::vector<std::size_t> order = Ascending(values);
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      ranks[order[i]] = 0.5 * static_cast<double>(begin + end + 1);
    }
    begin = end;
  }
  return ranks;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double AreaUnderCurve(const std::vector<double>& score, const std::vector<bool>& is_bad) {
  const std::vector<double> ranks = Ranks(score);
  double bad = 0, rank_sum = 0;
  for (std::size_t i = 0; i < score.size(); ++i) {
    if (!is_bad[i]) continue;
    bad += 1;
    rank_sum += ranks[i];
  }
  const double good = static_cast<double>(score.size()) - bad;
  if (bad == 0 || good == 0) return 0.5;
  return (rank_sum - bad * (bad + 1) / 2) / (bad * good);
}

double PrecisionRecall::F1() const {
  return precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0;
}

PrecisionRecall MeasureFlags(const std::vector<bool>& is_flagged, const std::vector<bool>& is_bad) {
  double flagged = 0, bad = 0, both = 0;
  for (std::size_t i = 0; i < is_bad.size(); ++i) {
    flagged += is_flagged[i];
    bad += is_bad[i];
    both += is_flagged[i] && is_bad[i];
  }
  return {flagged > 0 ? both / flagged : 1, bad > 0 ? both / bad : 1};
}

PrecisionRecall BestFlags(const std::vector<double>& score, const std::vector<bool>& is_bad) {
  const std::vector<std::size_t> order = Ascending(score);
  const auto all_bad = static_cast<double>(std::count(is_bad.begin(), is_bad.end(), true));
  PrecisionRecall best;
  double bad = 0;
  for (std::size_t k = order.size(); k-- > 0;) {
    bad += is_bad[order[k]];
    if (k > 0 && score[order[k - 1]] == score[order[k]]) continue;
    const PrecisionRecall now{bad / static_cast<double>(order.size() - k), bad / all_bad};
    if (now.F1() > best.F1()) best = now;
  }
  return best;
}

double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> ranks_a = Ranks(a), ranks_b = Ranks(b);
  const double mean = 0.5 * (static_cast<double>(a.size()) + 1);
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (ranks_a[i] - mean) * (ranks_b[i] - mean);
    aa += (ranks_a[i] - mean) * (ranks_a[i] - mean);
    bb += (ranks_b[i] - mean) * (ranks_b[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

std::vector<CalibrationBin> CalibrationCurve(const std::vector<double>& predicted,
                                             const std::vector<double>& measured,
                                             const std::vector<double>& edges) {
  std::vector<CalibrationBin> bins;
  for (std::size_t b = 0; b + 1 < edges.size(); ++b) {
    std::vector<double> in_bin, measured_in_bin;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      if (predicted[i] < edges[b] || predicted[i] >= edges[b + 1]) continue;
      in_bin.push_back(predicted[i]);
      measured_in_bin.push_back(measured[i]);
    }
    CalibrationBin bin{edges[b], edges[b + 1], in_bin.size(), 0, 0};
    if (!in_bin.empty()) {
      bin.predicted = MedianOf(std::move(in_bin));
      bin.measured = MedianOf(std::move(measured_in_bin));
    }
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace colmap_ext
