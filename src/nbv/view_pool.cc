#include "nbv/view_pool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "colmap_ext/util/parallel.h"
#include "nbv/view_fan.h"

namespace colmap_ext {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

// Looks at a point: angles off its normal, how many around it, and parts of the largest distance.
struct Ring {
  double angle_deg;
  int count;
};
constexpr std::array<Ring, 4> kRings = {{{0, 1}, {22, 4}, {42, 6}, {60, 6}}};
constexpr std::array<double, 3> kPartsOfRange = {0.45, 0.7, 0.95};

// Two unit vectors across `normal`, the first one level.
std::pair<Eigen::Vector3d, Eigen::Vector3d> Across(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d axis =
      std::abs(normal.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d u = axis.cross(normal).normalized();
  return {u, normal.cross(u)};
}

// Where to look at one point from. `turn_rad` turns the rings, so that neighbours' do not coincide.
void AddLooks(const SearchContext& context, const Eigen::Vector3d& point,
              const Eigen::Vector3d& normal, double turn_rad, Positions* positions) {
  const auto [u, v] = Across(normal);
  const NextBestViewOptions& options = context.options;
  const double f_squared = context.camera().fx * context.camera().fy;
  for (const Ring& ring : kRings) {
    const double angle = DegToRad(ring.angle_deg);
    const double range =
        context.min_projection_ratio > 0
            ? std::min(options.max_range_m,
                       std::sqrt(f_squared * std::cos(angle) / context.min_projection_ratio))
            : options.max_range_m;
    for (int k = 0; k < ring.count; ++k) {
      const double around = turn_rad + 2 * M_PI * k / ring.count;
      const Eigen::Vector3d toward =
          std::cos(angle) * normal +
          std::sin(angle) * (std::cos(around) * u + std::sin(around) * v);
      for (const double part : kPartsOfRange) {
        positions->push_back(point + part * range * toward);
      }
    }
  }
}

Positions Looks(const SearchContext& context, const UncoveredPoints& points) {
  const std::size_t looks_a_point = 17 * kPartsOfRange.size();
  constexpr std::size_t kLooksAPosition = 8;
  const auto wanted = kLooksAPosition * static_cast<std::size_t>(context.options.num_positions);
  const std::size_t num_points = std::max<std::size_t>(1, wanted / looks_a_point);
  const std::size_t stride = std::max<std::size_t>(1, points.size() / num_points);
  constexpr double kGoldenAngle = 2.399963229728653;
  Positions positions;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    AddLooks(context, points.position(i), points.normal(i), kGoldenAngle * static_cast<double>(i),
             &positions);
  }
  return positions;
}

// The first position of every cube of the smallest size that leaves at most `wanted`.
Positions Thinned(const Positions& positions, double smallest_m, std::size_t wanted) {
  std::unordered_set<std::uint64_t> cubes;
  for (double size = smallest_m;; size *= 1.25) {
    cubes.clear();
    Positions kept;
    for (const Eigen::Vector3d& p : positions) {
      std::uint64_t key = 0;
      for (int k = 0; k < 3; ++k) {  // 21 bits a coordinate
        const auto cell = static_cast<std::int64_t>(std::floor(p[k] / size));
        key = (key << 21) | (static_cast<std::uint64_t>(cell) & 0x1fffff);
      }
      if (!cubes.insert(key).second) continue;
      kept.push_back(p);
      if (kept.size() > wanted) break;
    }
    if (kept.size() <= wanted) return kept;
  }
}

Positions OnlyFree(const SearchContext& context, const Positions& positions) {
  std::vector<char> is_free(positions.size(), 0);
  ParallelFor(positions.size(),
              [&](std::size_t i) { is_free[i] = IsFreePosition(context, positions[i]) ? 1 : 0; });
  Positions free;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (is_free[i] != 0) free.push_back(positions[i]);
  }
  return free;
}

// All that are free; those of the pool are thinned further.
Positions FreePositions(const SearchContext& context, const UncoveredPoints& points) {
  const auto wanted = static_cast<std::size_t>(context.options.num_positions);
  const double smallest_m = context.options.grid_spacing_m;
  Positions flown;
  for (const PosedPhoto& photo : context.input.existing) {
    flown.push_back(CameraCenter(photo.cam_from_world));
  }
  Positions positions = Thinned(flown, smallest_m, wanted / 4 + 1);
  const Positions looks = Thinned(Looks(context, points), 0.5 * smallest_m, 3 * wanted);
  positions.insert(positions.end(), looks.begin(), looks.end());
  return OnlyFree(context, positions);
}

// Of one position: each direction with the points that it sees.
class Directions {
 public:
  Directions(const SearchContext& context, const std::vector<ViewDirection>& directions)
      : context_(context), directions_(directions), fan_(context, directions) {}

  void LookFrom(const Eigen::Vector3d& position, const UncoveredPoints& points) {
    seen_.clear();
    first_.assign(1, 0);
    points_.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!fan_.IsInReach(position, points.position(i), points.normal(i)) ||
          points.WeightFrom(i, position) <= 0 ||
          !fan_.LookAt(position, points.position(i), points.normal(i)) ||
          !context_.engine.IsUnoccluded(position, points.position(i), points.normal(i))) {
        continue;
      }
      for (const auto& [k, ratio] : fan_.seen()) seen_.push_back(static_cast<std::uint32_t>(k));
      first_.push_back(seen_.size());
      points_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  // Again and again the direction that sees most of what those before it do not see; what they do
  // counts a little.
  std::vector<std::size_t> Best(int count) const {
    constexpr double kSeenBefore = 0.2;
    std::vector<double> worth(points_.size(), 1);
    std::vector<std::size_t> best;
    while (best.size() < static_cast<std::size_t>(count)) {
      std::vector<double> scores(directions_.size(), 0);
      for (std::size_t p = 0; p < points_.size(); ++p) {
        for (std::size_t e = first_[p]; e < first_[p + 1]; ++e) scores[seen_[e]] += worth[p];
      }
      for (const std::size_t k : best) scores[k] = 0;
      const auto top = std::max_element(scores.begin(), scores.end());
      if (top == scores.end() || *top <= 0) break;
      best.push_back(static_cast<std::size_t>(top - scores.begin()));
      for (std::size_t p = 0; p < points_.size(); ++p) {
        if (Sees(p, best.back())) worth[p] = kSeenBefore;
      }
    }
    return best;
  }

  std::vector<std::uint32_t> SeenBy(std::size_t direction) const {
    std::vector<std::uint32_t> list;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (Sees(p, direction)) list.push_back(points_[p]);
    }
    return list;
  }

 private:
  bool Sees(std::size_t p, std::size_t direction) const {
    const auto begin = seen_.begin() + static_cast<std::ptrdiff_t>(first_[p]);
    const auto end = seen_.begin() + static_cast<std::ptrdiff_t>(first_[p + 1]);
    return std::find(begin, end, static_cast<std::uint32_t>(direction)) != end;
  }

  const SearchContext& context_;
  const std::vector<ViewDirection>& directions_;
  ViewFan fan_;
  std::vector<std::uint32_t> points_;  // not hidden
  std::vector<std::size_t> first_;     // of each of them in seen_; one more at the end
  std::vector<std::uint32_t> seen_;    // directions
};

}  // namespace

std::vector<char> SeenByAny(const std::vector<PoolView>& pool, std::size_t num_points) {
  std::vector<char> is_seen(num_points, 0);
  for (const PoolView& view : pool) {
    for (const std::uint32_t point : view.seen) is_seen[point] = 1;
  }
  return is_seen;
}

std::size_t PartSeen(const std::vector<PoolView>& pool, std::size_t num_points,
                     std::size_t uncovered) {
  const std::vector<char> is_seen = SeenByAny(pool, num_points);
  const auto num_seen = static_cast<double>(std::count(is_seen.begin(), is_seen.end(), 1));
  return static_cast<std::size_t>(num_seen / static_cast<double>(num_points) *
                                  static_cast<double>(uncovered));
}

PoolView EvaluateView(const SearchContext& context, const UncoveredPoints& points,
                      const Eigen::Vector3d& position, const ViewDirection& direction) {
  const std::vector<ViewDirection> directions = {direction};
  Directions at(context, directions);
  at.LookFrom(position, points);
  return {position, direction, 0, at.SeenBy(0)};
}

ViewPool BuildViewPool(const SearchContext& context, const UncoveredPoints& points) {
  ViewPool pool;
  if (points.size() == 0) return pool;
  std::vector<ViewDirection> directions;
  for (const double yaw : context.yaws_rad) {
    for (const double pitch : context.pitches_rad) directions.push_back({yaw, pitch});
  }
  pool.free_positions = FreePositions(context, points);
  const Positions positions = Thinned(pool.free_positions, 0.5 * context.options.grid_spacing_m,
                                      static_cast<std::size_t>(context.options.num_positions));
  std::vector<std::vector<PoolView>> by_place(positions.size());
  ParallelFor(positions.size(), [&](std::size_t i) {
    Directions at(context, directions);
    at.LookFrom(positions[i], points);
    for (const std::size_t k : at.Best(context.options.views_a_position)) {
      by_place[i].push_back(
          {positions[i], directions[k], static_cast<std::uint32_t>(i), at.SeenBy(k)});
    }
  });
  for (std::vector<PoolView>& views : by_place) {
    for (PoolView& view : views) pool.views.push_back(std::move(view));
  }
  return pool;
}

}  // namespace colmap_ext
