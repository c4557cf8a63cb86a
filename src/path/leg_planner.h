#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "colmap_ext/path/free_space.h"
#include "colmap_ext/path/grid_search.h"
#include "colmap_ext/path/path_planner.h"

namespace colmap_ext {

// Finds and proves the way between two places. May be asked from many threads; what it learns about
// a cell is kept.
class LegPlanner {
 public:
  // `box`: what the search grid covers. Throws Error when that would be too many cells.
  LegPlanner(const FreeSpace& free_space, const Eigen::AlignedBox3d& box,
             const PathOptions& options);

  // Corners of a proved polyline from a to b, both included; empty when none was found.
  std::vector<Eigen::Vector3d> FindLeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  // Clearance, known space and ceiling hold on every point of the segment.
  bool IsSegmentProved(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  // Why a vehicle may not hover at `point`; empty when it may.
  std::string WhyNotAt(const Eigen::Vector3d& point) const;

  // The cell nearest to `point`, among those around it, that `is_reachable` accepts.
  std::optional<Eigen::Vector3d> NearestFreeCenter(
      const Eigen::Vector3d& point, int rings,
      const std::function<bool(const Eigen::Vector3d&)>& is_reachable) const;

 private:
  bool IsKnown(const Cell& cell) const;
  bool IsFree(const Cell& cell) const;
  bool IsStepProved(const Cell& from, const Cell& to) const;
  double ClearanceAt(const Cell& cell) const;
  std::vector<Eigen::Vector3d> PullStraight(const std::vector<Eigen::Vector3d>& polyline) const;

  const FreeSpace& free_space_;
  const PathOptions& options_;
  VoxelGrid grid_;
  // Caches over the cells. Two threads may compute the same value, but never different ones.
  mutable std::vector<std::atomic<float>> clearance_m_;     // < 0: not computed yet
  mutable std::vector<std::atomic<signed char>> is_known_;  // < 0: not computed yet
};

}  // namespace colmap_ext
