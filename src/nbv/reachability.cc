#include "nbv/reachability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "colmap_ext/util/parallel.h"
#include "nbv/view_fan.h"

namespace colmap_ext {
namespace {

// The lattice has at most about this many positions; beyond, it is made coarser.
constexpr double kMaxPositions = 200000;

double DistanceToAnchors(const std::vector<Anchor>& anchors, const Eigen::Vector3d& position) {
  double distance = std::numeric_limits<double>::infinity();
  for (const Anchor& anchor : anchors) {
    distance = std::min(distance, (anchor.position - position).norm());
  }
  return distance;
}

std::vector<Eigen::Vector3d> LatticeAround(const SearchContext& context,
                                           const UncoveredPoints& points) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < points.size(); ++i) box.extend(points.position(i));
  const double range = UsefulRange(context);
  box = Eigen::AlignedBox3d(box.min().array() - range, box.max().array() + range);
  box.min().z() = context.lowest_altitude_m;
  if (box.isEmpty()) return {};
  double spacing = 2 * context.options.grid_spacing_m;
  const double num_positions = box.volume() / (spacing * spacing * spacing);
  if (num_positions > kMaxPositions) spacing *= std::cbrt(num_positions / kMaxPositions);
  std::vector<Eigen::Vector3d> positions;
  for (double z = box.min().z(); z <= box.max().z(); z += spacing) {
    for (double y = box.min().y(); y <= box.max().y(); y += spacing) {
      for (double x = box.min().x(); x <= box.max().x(); x += spacing) {
        positions.emplace_back(x, y, z);
      }
    }
  }
  return positions;
}

// Free positions, those near to existing views first.
std::vector<Eigen::Vector3d> FreePositions(const SearchContext& context,
                                           const UncoveredPoints& points,
                                           const std::vector<Anchor>& anchors) {
  std::vector<Eigen::Vector3d> positions = LatticeAround(context, points);
  for (const Anchor& anchor : anchors) positions.push_back(anchor.position);
  std::vector<double> distances(positions.size());
  ParallelFor(positions.size(), [&](std::size_t i) {
    distances[i] = IsFreePosition(context, positions[i]) ? DistanceToAnchors(anchors, positions[i])
                                                         : std::numeric_limits<double>::infinity();
  });
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (std::isfinite(distances[i])) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(distances[a], a) < std::tie(distances[b], b);
  });
  std::vector<Eigen::Vector3d> sorted;
  for (const std::size_t i : order) sorted.push_back(positions[i]);
  return sorted;
}

// All directions of the search.
std::vector<ViewDirection> AllDirections(const SearchContext& context) {
  std::vector<ViewDirection> directions;
  for (const double yaw : context.yaws_rad) {
    for (const double pitch : context.pitches_rad) directions.push_back({yaw, pitch});
  }
  return directions;
}

// From each position the direction whose optical axis is nearest to the point is taken: where it is
// deepest, so that its projection ratio is smallest.
std::optional<ReachingView> FirstReachingView(const SearchContext& context,
                                              const std::vector<Eigen::Vector3d>& positions,
                                              const std::vector<ViewDirection>& directions,
                                              const UncoveredPoints& points, std::size_t i) {
  ViewFan fan(context, directions);
  const Eigen::Vector3d& point = points.position(i);
  const Eigen::Vector3d& normal = points.normal(i);
  for (const Eigen::Vector3d& position : positions) {
    if (!fan.IsInReach(position, point, normal) || !fan.LookAt(position, point, normal) ||
        points.WeightFrom(i, position) <= 0 ||
        !context.engine.IsUnoccluded(position, point, normal)) {
      continue;
    }
    const auto nearest =
        std::min_element(fan.seen().begin(), fan.seen().end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    return ReachingView{position, directions[nearest->first]};
  }
  return std::nullopt;
}

// How many steps within the limits lead from the anchor to the view.
double Hops(const NextBestViewOptions& options, const Anchor& anchor, const ReachingView& view) {
  constexpr double kPartOfLimit = 0.9;  // the vehicle does not arrive exactly where it was sent
  const double max_angle_rad = kPartOfLimit * DegToRad(options.max_angle_to_existing_deg);
  const double distance = (anchor.position - view.position).norm() /
                          (kPartOfLimit * options.max_distance_to_existing_m);
  const double yaw =
      std::abs(NormalizeAngle(view.direction.yaw_rad - anchor.direction.yaw_rad)) / max_angle_rad;
  const double pitch =
      std::abs(view.direction.pitch_rad - anchor.direction.pitch_rad) / max_angle_rad;
  return std::max({distance, yaw, pitch, 1e-9});
}

// The chain, or nothing when one of its views is not free.
std::vector<ReachingView> ChainOfViews(const SearchContext& context, const Anchor& anchor,
                                       const ReachingView& target, double hops) {
  std::vector<ReachingView> chain;
  const int steps = static_cast<int>(std::ceil(hops - 1e-9));
  const double turn = NormalizeAngle(target.direction.yaw_rad - anchor.direction.yaw_rad);
  const double tilt = target.direction.pitch_rad - anchor.direction.pitch_rad;
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Eigen::Vector3d position = anchor.position + t * (target.position - anchor.position);
    if (!IsFreePosition(context, position) || !MayReach(context, position)) return {};
    chain.push_back({position,
                     {NormalizeAngle(anchor.direction.yaw_rad + t * turn),
                      anchor.direction.pitch_rad + t * tilt}});
  }
  return chain;
}

}  // namespace

std::vector<std::optional<ReachingView>> FindReachingViews(
    const SearchContext& context, const UncoveredPoints& points,
    const std::vector<Eigen::Vector3d>& positions) {
  std::vector<std::optional<ReachingView>> views(points.size());
  const std::vector<ViewDirection> directions = AllDirections(context);
  ParallelFor(points.size(), [&](std::size_t i) {
    views[i] = FirstReachingView(context, positions, directions, points, i);
  });
  return views;
}

std::vector<std::optional<ReachingView>> FindReachingViews(const SearchContext& context,
                                                           const UncoveredPoints& points,
                                                           const std::vector<Anchor>& anchors) {
  if (points.size() == 0) return {};
  return FindReachingViews(context, points, FreePositions(context, points, anchors));
}

std::vector<ReachingView> FindBridge(const SearchContext& context,
                                     const std::vector<Anchor>& anchors,
                                     const std::vector<std::optional<ReachingView>>& targets) {
  struct Attempt {
    double hops;
    std::size_t target, anchor;
    bool operator<(const Attempt& other) const {
      return std::tie(hops, target, anchor) < std::tie(other.hops, other.target, other.anchor);
    }
  };
  // For each target its nearest anchor.
  std::vector<Attempt> attempts;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    if (!targets[t]) continue;
    Attempt best{std::numeric_limits<double>::infinity(), t, 0};
    for (std::size_t a = 0; a < anchors.size(); ++a) {
      best = std::min(best, Attempt{Hops(context.options, anchors[a], *targets[t]), t, a});
    }
    attempts.push_back(best);
  }
  std::sort(attempts.begin(), attempts.end());
  for (const Attempt& attempt : attempts) {
    std::vector<ReachingView> chain =
        ChainOfViews(context, anchors[attempt.anchor], *targets[attempt.target], attempt.hops);
    const auto num_views = static_cast<std::size_t>(context.options.num_views);
    if (chain.size() > num_views) chain.resize(num_views);
    if (!chain.empty()) return chain;
  }
  return {};
}

}  // namespace colmap_ext
