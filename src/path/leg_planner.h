#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "colmap_ext/path/free_space.h"
#include "colmap_ext/path/grid_search.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/path/segment_check.h"

namespace colmap_ext {

// Finds and proves the way between two places. May be asked from many threads; what it learns about
// a cell is kept.
class LegPlanner {
 public:
  // `box`: what the search grid covers. Throws Error when that would be too many cells.
  LegPlanner(const FreeSpace& free_space, const SegmentRules& rules, const Eigen::AlignedBox3d& box,
             double cell_size_m);

  const FreeSpace& free_space() const { return free_space_; }
  const SegmentRules& rules() const { return rules_; }

  // Corners of a proved polyline from a to b, both included; empty when none was found.
  std::vector<Eigen::Vector3d> FindLeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  // As WhyNotFly, with what is known about the cells at hand.
  bool IsSegmentProved(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  // The search grid: whether the vehicle may be anywhere in a cell's middle, and fly straight from
  // one cell's middle to a neighbour's (both free).
  const VoxelGrid& grid() const { return grid_; }
  bool IsFree(const Cell& cell) const;
  bool IsStepProved(const Cell& from, const Cell& to) const;

  // The cell nearest to `point`, among those around it, that `is_reachable` accepts.
  std::optional<Eigen::Vector3d> NearestFreeCenter(
      const Eigen::Vector3d& point, int rings,
      const std::function<bool(const Eigen::Vector3d&)>& is_reachable) const;

 private:
  bool IsKnown(const Cell& cell) const;
  double ClearanceAt(const Cell& cell) const;
  std::vector<Eigen::Vector3d> PullStraight(const std::vector<Eigen::Vector3d>& polyline) const;

  const FreeSpace& free_space_;
  SegmentRules rules_;
  SegmentRules rules_in_known_space_;  // the same where it is known already
  VoxelGrid grid_;
  // Caches over the cells. Two threads may compute the same value, but never different ones.
  mutable std::vector<std::atomic<float>> clearance_m_;     // < 0: not computed yet
  mutable std::vector<std::atomic<signed char>> is_known_;  // < 0: not computed yet
};

}  // namespace colmap_ext
