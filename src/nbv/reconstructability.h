#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "nbv/search_context.h"
#include "nbv/uncovered_points.h"

namespace colmap_ext {

// The reconstructability heuristic of Smith, Moehrle, Goesele and Heidrich, "Aerial Path Planning
// for Urban Scene Reconstruction: A Continuous Optimization Method and Benchmark" (ACM Transactions
// on Graphics 37(6), 2018). For a point with normal n that the views i and j see, from distances
// d_i, d_j, at the angle α between them and θ_i, θ_j off the normal:
//
//   q_ij = w1(α) w2(d) w3(α) cos θ,   d = max(d_i, d_j),   cos θ = min(cos θ_i, cos θ_j)
//   w1(α) = 1 / (1 + exp(−k1 (α − α1)))        enough parallax     k1 = 32, α1 = π/16
//   w2(d) = 1 − min(d / d_max, 1)              resolution          d_max: where γ_min is reached
//   w3(α) = 1 − 1 / (1 + exp(−k3 (α − α3)))    can be matched      k3 = 8,  α3 = π/4
//
//   h(point) = Σ_{i<j} q_ij
//
// Ours: what is maximised is Σ_points min(h, kEnough), so that no point is seen ever more often.
class Reconstructability {
 public:
  static constexpr double kEnough = 1.5;

  struct PointView {
    Eigen::Vector3d toward;  // unit, from the point to the camera
    double distance_m = 0;
    double cos_incidence = 0;
  };

  // Of `points`, as `existing` photos see them. d_max from the camera and γ_min of the context.
  Reconstructability(const SearchContext& context, const UncoveredPoints& points,
                     const std::vector<PosedPhoto>& existing);

  // q of a pair of views of one point.
  static double OfPair(const PointView& first, const PointView& second, double max_distance_m);

  double HeuristicOf(std::size_t point) const { return h_[point]; }
  double Total() const;  // Σ min(h, kEnough)

  // What a view from `center` that sees `seen` adds to Total().
  double Gain(const Eigen::Vector3d& center, const std::vector<std::uint32_t>& seen) const;
  void Add(const Eigen::Vector3d& center, const std::vector<std::uint32_t>& seen);
  // Takes a view away that was added with the same `seen`.
  void Remove(const Eigen::Vector3d& center, const std::vector<std::uint32_t>& seen);

 private:
  PointView ViewFrom(std::size_t point, const Eigen::Vector3d& center) const;
  double SumOfPairs(std::size_t point, const PointView& view) const;

  const UncoveredPoints& points_;
  double max_distance_m_;
  std::vector<std::vector<PointView>> views_;  // of each point
  std::vector<double> h_;
};

}  // namespace colmap_ext
