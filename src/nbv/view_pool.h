#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "nbv/search_context.h"
#include "nbv/uncovered_points.h"

namespace colmap_ext {

// A candidate: where, and which of the points it sees (at γ_min with the reserve, not hidden, not
// as a mere repetition of an existing view).
struct PoolView {
  Eigen::Vector3d position;
  ViewDirection direction;
  std::uint32_t place = 0;  // the same for views from one position
  std::vector<std::uint32_t> seen;
};

struct ViewPool {
  std::vector<PoolView> views;
  std::vector<Eigen::Vector3d> free_positions;  // that were found, also those thinned out
};

// Views from which `points` are seen well: free positions on cones around the points' normals, at
// several parts of the largest distance that gives γ_min there, thinned to about num_positions;
// and the positions of existing photos. Of the directions at each (all pitches and yaws of the
// context) the views_a_position best are kept, each for what those before it do not see.
ViewPool BuildViewPool(const SearchContext& context, const UncoveredPoints& points);

// Of each of `num_points` points whether some view of the pool sees it.
std::vector<char> SeenByAny(const std::vector<PoolView>& pool, std::size_t num_points);

// Of `uncovered` points as many as is the part that some view of the pool sees of `num_points`.
std::size_t PartSeen(const std::vector<PoolView>& pool, std::size_t num_points,
                     std::size_t uncovered);

// One more view, as seen by the rules above; `place` is left 0.
PoolView EvaluateView(const SearchContext& context, const UncoveredPoints& points,
                      const Eigen::Vector3d& position, const ViewDirection& direction);

}  // namespace colmap_ext
