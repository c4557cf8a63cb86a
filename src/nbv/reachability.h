#pragma once

#include <optional>
#include <vector>

#include "nbv/search_context.h"
#include "nbv/uncovered_points.h"

namespace colmap_ext {

// A view in free space, near to existing ones or not, that sees an uncovered point at >= γ_min.
struct ReachingView {
  Eigen::Vector3d position;
  ViewDirection direction;
};

// For every uncovered point the first view from one of `positions` that sees it and does not merely
// repeat a good view of it; nullopt where there is none. Directions: all pitches and yaws of the
// context.
std::vector<std::optional<ReachingView>> FindReachingViews(
    const SearchContext& context, const UncoveredPoints& points,
    const std::vector<Eigen::Vector3d>& positions);

// The same from everywhere, near to existing views first: free positions of a lattice around the
// points of twice the grid spacing, and those of the anchors.
std::vector<std::optional<ReachingView>> FindReachingViews(const SearchContext& context,
                                                           const UncoveredPoints& points,
                                                           const std::vector<Anchor>& anchors);

// The shortest chain of views from an anchor to one of `targets`: evenly spaced on a straight line
// and turning evenly, each near (9/10 of the limits) to the one before it and in free space; the
// anchor left out, the target the last. At most num_views are returned, the first ones: the next
// plan goes on from there. Empty when no chain is free.
std::vector<ReachingView> FindBridge(const SearchContext& context,
                                     const std::vector<Anchor>& anchors,
                                     const std::vector<std::optional<ReachingView>>& targets);

}  // namespace colmap_ext
