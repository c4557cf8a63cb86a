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

}  // namespace

std::vector<int> ShortOpenTour(const Eigen::MatrixXd& length) {
  if (length.rows() == 0) return {};
  std::vector<int> tour = NearestNeighbourTour(length);
  constexpr double kLeastSaving_m = 1e-9;  // so that rounding cannot exchange for ever
  bool improved = true;
  while (improved) {
    improved = false;
    for (std::size_t i = 1; i < tour.size(); ++i) {
      for (std::size_t j = i + 1; j < tour.size(); ++j) {
        if (Saving(length, tour, i, j) <= kLeastSaving_m) continue;
        std::reverse(tour.begin() + static_cast<std::ptrdiff_t>(i),
                     tour.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        improved = true;
      }
    }
  }
  return tour;
}

}  // namespace colmap_ext
