#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nbv/feature_overlap.h"
#include "nbv/uncovered_points.h"
#include "nbv/view_pool.h"
#include "nbv/view_tour.h"

namespace colmap_ext {

// Greedy choice of views from a pool: each time the admissible one that adds most stereo coverage
// (times the sun's factor), or most of it for a second of the tour. Gains are kept up to date by
// point: when a point's state changes, the views that see it are told. No gain is ever evaluated in
// vain, which is what lazy evaluation is for, and gains that rise are no harm.
class StereoGreedy {
 public:
  StereoGreedy(const SearchContext& context, const std::vector<PoolView>& pool,
               const UncoveredPoints& points, const FeatureOverlap& overlap,
               const Eigen::Vector3d& start);

  enum class Rule { kGain, kGainForTime };
  // Adds views until there are num_views, the budget of the tour is used up, or no admissible one
  // gains enough.
  void Run(Rule rule, const JobControl& job);

  // The views of the pool that would gain something but may not be added, best first.
  std::vector<std::size_t> Wanting(std::size_t count) const;
  // Adds a view that is not in the pool, for example of a bridge; false when the budget forbids.
  bool Add(const PoolView& view);

  void PolishTour() { tour_.Improve(); }

  const std::vector<PoolView>& views() const { return views_; }
  const std::vector<double>& shared_features() const { return shared_; }
  const ViewTour& tour() const { return tour_; }
  const FeatureOverlap& overlap() const { return overlap_; }
  double coverage() const { return coverage_; }  // gained, in points

 private:
  struct Entry {
    std::uint32_t view;
    float gain;
  };

  std::optional<std::size_t> Best(Rule rule);
  double Worth(std::size_t view, Rule rule) const;
  void UpdatePoint(std::uint32_t point);
  void AskAgain(const PoolView& added);

  const SearchContext& context_;
  const std::vector<PoolView>& pool_;
  UncoveredPoints points_;
  FeatureOverlap overlap_;
  ViewTour tour_;

  std::vector<std::vector<Entry>> seen_by_;  // of each point
  std::vector<double> gain_;                 // of each view of the pool
  std::vector<double> sun_;
  std::vector<char> is_refused_;  // was found to share too few features
  std::vector<char> is_barred_;   // place that no way leads to
  std::vector<double> reach_m_;   // from the middle of a view that shares features with it
  std::vector<FeatureOverlap::Sight> sights_;  // of each place

  std::vector<PoolView> views_;
  std::vector<double> shared_;
  double coverage_ = 0;
  double first_gain_ = 0;
  int times_asked_all_ = 0;
  std::size_t asked_all_at_ = 0;  // number of views then
};

}  // namespace colmap_ext
