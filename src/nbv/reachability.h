#pragma once

#include <optional>
#include <vector>

#include "nbv/candidates.h"

namespace colmap_ext {

// A view in free space, near to existing ones or not, that sees an uncovered point at >= γ_min.
struct ReachingView {
  Eigen::Vector3d position;
  ViewDirection direction;
};

// For every uncovered point the first view that sees it and does not merely repeat a good view of
// it, looking from positions near to existing views outwards; nullopt where there is none.
// Positions: a lattice around the points of twice the grid spacing, and those of the anchors. Its
// directions: all pitches, and the yaws next to the point.
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
