#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "colmap_ext/nbv/next_best_views.h"

namespace colmap_ext {

// An open tour (closed with return_to_start) from a start over stops, grown by cheapest insertion
// and kept short by 2-opt. Straight legs: what a path between obstacles takes, no less.
class ViewTour {
 public:
  ViewTour(const Eigen::Vector3d& start, const NextBestViewOptions& options);

  // Metres that the tour gets longer by with the cheapest insertion of a stop there.
  double ExtraLength(const Eigen::Vector3d& position) const;
  // The same in seconds: flight, a photo, and a turn of 45 degrees.
  double ExtraDuration(const Eigen::Vector3d& position) const;
  // Whether the budgets of the options permit one more stop there.
  bool Permits(const Eigen::Vector3d& position) const;

  void Insert(const Eigen::Vector3d& position);

  // 2-opt; done now and then by Insert.
  void Improve();

  // Indices of the stops, as they were inserted, in the order of the tour.
  const std::vector<std::size_t>& order() const { return order_; }
  double length_m() const { return length_m_; }
  double duration_s() const;

 private:
  std::size_t CheapestPlace(const Eigen::Vector3d& position, double* extra_m) const;
  const Eigen::Vector3d& At(std::size_t k) const;  // k-th place of the tour; 0: the start
  double Leg(std::size_t k) const;                 // from the k-th place to the next one

  const NextBestViewOptions& options_;
  Eigen::Vector3d start_;
  std::vector<Eigen::Vector3d> stops_;
  std::vector<std::size_t> order_;
  double length_m_ = 0;
};

}  // namespace colmap_ext
