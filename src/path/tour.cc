#include "path/tour.h"

#include <algorithm>

namespace colmap_ext {
namespace {

std::vector<int> NearestNeighbourTour(const Eigen::MatrixXd& length) {
  const int n = static_cast<int>(length.rows());
  std::vector<int> tour = {0};
  std::vector<bool> visited(static_cast<std::size_t>(n), false);
  visited[0] = true;
  while (static_cast<int>(tour.size()) < n) {
    int nearest = -1;
    for (int i = 1; i < n; ++i) {
      if (visited[static_cast<std::size_t>(i)]) continue;
      if (nearest < 0 || length(tour.back(), i) < length(tour.back(), nearest)) nearest = i;
    }
    visited[static_cast<std::size_t>(nearest)] = true;
    tour.push_back(nearest);
  }
  return tour;
}

// What is saved by flying tour[i … j] backwards.
double Saving(const Eigen::MatrixXd& length, const std::vector<int>& tour, std::size_t i,
              std::size_t j) {
  double saving = length(tour[i - 1], tour[i]) - length(tour[i - 1], tour[j]);
  if (j + 1 < tour.size()) saving += length(tour[j], tour[j + 1]) - length(tour[i], tour[j + 1]);
  return saving;
}

constexpr double kLeastSaving_m = 1e-9;  // so that rounding cannot exchange for ever

bool ImproveByTwoOpt(const Eigen::MatrixXd& length, std::vector<int>* tour) {
  bool improved = false;
  for (std::size_t i = 1; i < tour->size(); ++i) {
    for (std::size_t j = i + 1; j < tour->size(); ++j) {
      if (Saving(length, *tour, i, j) <= kLeastSaving_m) continue;
      std::reverse(tour->begin() + static_cast<std::ptrdiff_t>(i),
                   tour->begin() + static_cast<std::ptrdiff_t>(j) + 1);
      improved = true;
    }
  }
  return improved;
}

// Length of the link from tour[i] to tour[j]; 0 beyond the end.
double Link(const Eigen::MatrixXd& length, const std::vector<int>& tour, std::size_t i,
            std::size_t j) {
  return j < tour.size() ? length(tour[i], tour[j]) : 0;
}

// Moves tour[i … j] to behind tour[k], either way round, where that is shortest. k is outside of
// i - 1 … j.
bool MoveRun(const Eigen::MatrixXd& length, std::size_t i, std::size_t j, std::size_t k,
             std::vector<int>* tour) {
  const std::vector<int>& t = *tour;
  const double removed = Link(length, t, i - 1, i) + Link(length, t, j, j + 1) -
                         (j + 1 < t.size() ? length(t[i - 1], t[j + 1]) : 0);
  const double opened = Link(length, t, k, k + 1);
  const double same_way =
      length(t[k], t[i]) + (k + 1 < t.size() ? length(t[j], t[k + 1]) : 0) - opened;
  const double reversed =
      length(t[k], t[j]) + (k + 1 < t.size() ? length(t[i], t[k + 1]) : 0) - opened;
  if (removed - std::min(same_way, reversed) <= kLeastSaving_m) return false;
  std::vector<int> run(t.begin() + static_cast<std::ptrdiff_t>(i),
                       t.begin() + static_cast<std::ptrdiff_t>(j) + 1);
  if (reversed < same_way) std::reverse(run.begin(), run.end());
  tour->erase(tour->begin() + static_cast<std::ptrdiff_t>(i),
              tour->begin() + static_cast<std::ptrdiff_t>(j) + 1);
  const std::size_t behind = k < i ? k : k - run.size();
  tour->insert(tour->begin() + static_cast<std::ptrdiff_t>(behind) + 1, run.begin(), run.end());
  return true;
}

bool ImproveByOrOpt(const Eigen::MatrixXd& length, std::vector<int>* tour) {
  constexpr std::size_t kLongestRun = 3;
  bool improved = false;
  for (std::size_t run = 1; run <= kLongestRun; ++run) {
    for (std::size_t i = 1; i + run <= tour->size(); ++i) {
      const std::size_t j = i + run - 1;
      for (std::size_t k = 0; k < tour->size(); ++k) {
        if (k + 1 >= i && k <= j) continue;
        if (!MoveRun(length, i, j, k, tour)) continue;
        improved = true;
        break;
      }
    }
  }
  return improved;
}

}  // namespace

std::vector<int> ShortOpenTour(const Eigen::MatrixXd& length) {
  if (length.rows() == 0) return {};
  std::vector<int> tour = NearestNeighbourTour(length);
  while (ImproveByTwoOpt(length, &tour) || ImproveByOrOpt(length, &tour)) {
  }
  return tour;
}

}  // namespace colmap_ext
