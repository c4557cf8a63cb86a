#include "path/leg_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/path/clearance.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kMaxCells = 2e8;

void RequireNotTooManyCells(const Eigen::AlignedBox3d& box, double cell_size_m) {
  const Eigen::Vector3d cells = (box.sizes() / cell_size_m).array().ceil().max(1.0);
  if (!(cells.prod() <= kMaxCells)) {
    throw Error(
        "path: the search grid would have more than 200 million cells; choose a larger "
        "--Path.cell_size_m or a smaller --Path.detour_margin_m");
  }
}

}  // namespace

LegPlanner::LegPlanner(const FreeSpace& free_space, const SegmentRules& rules,
                       const Eigen::AlignedBox3d& box, double cell_size_m)
    : free_space_(free_space), rules_(rules), rules_in_known_space_(rules) {
  rules_in_known_space_.unknown_is_free = true;
  // At multiples of the cell size: what is known does not depend on which views are planned.
  const Eigen::Vector3d low = (box.min() / cell_size_m).array().floor() * cell_size_m;
  const Eigen::AlignedBox3d aligned(low, box.max());
  RequireNotTooManyCells(aligned, cell_size_m);
  grid_ = VoxelGrid(aligned, cell_size_m);
  clearance_m_ = std::vector<std::atomic<float>>(grid_.NumCells());
  is_known_ = std::vector<std::atomic<signed char>>(grid_.NumCells());
  for (std::size_t i = 0; i < grid_.NumCells(); ++i) {
    clearance_m_[i].store(-1, std::memory_order_relaxed);
    is_known_[i].store(-1, std::memory_order_relaxed);
  }
}

bool LegPlanner::IsKnown(const Cell& cell) const {
  if (rules_.unknown_is_free) return true;
  if (!grid_.Contains(cell)) return false;
  std::atomic<signed char>& known = is_known_[grid_.Index(cell)];
  if (known.load(std::memory_order_relaxed) < 0) {
    // The ball around the whole cell, and around it what the vehicle may be off.
    const double radius_m = std::sqrt(3.0) / 2 * grid_.cell_size_m() + rules_.position_error_m;
    const bool is_known = free_space_.IsKnownFree(grid_.Center(cell), radius_m);
    known.store(is_known ? 1 : 0, std::memory_order_relaxed);
  }
  return known.load(std::memory_order_relaxed) > 0;
}

double LegPlanner::ClearanceAt(const Cell& cell) const {
  std::atomic<float>& clearance = clearance_m_[grid_.Index(cell)];
  if (clearance.load(std::memory_order_relaxed) < 0) {
    // Twice the distance is enough to prove any step.
    const double max_m = 2 * rules_.ClearanceOfLine() + 4 * grid_.cell_size_m();
    clearance.store(
        static_cast<float>(free_space_.ray_scene().DistanceToSurface(grid_.Center(cell), max_m)),
        std::memory_order_relaxed);
  }
  return static_cast<double>(clearance.load(std::memory_order_relaxed));
}

bool LegPlanner::IsFree(const Cell& cell) const {
  if (!grid_.Contains(cell)) return false;
  const double top = grid_.Center(cell).z() + rules_.position_error_m;
  if (rules_.max_altitude_m != 0 && top > rules_.max_altitude_m) return false;
  if (!rules_.limits.Allows(grid_.Center(cell), rules_.position_error_m)) return false;
  return ClearanceAt(cell) >= rules_.ClearanceOfLine() + rules_.proof_tolerance_m && IsKnown(cell);
}

bool LegPlanner::IsStepProved(const Cell& from, const Cell& to) const {
  const double length = grid_.cell_size_m() * (to - from).cast<double>().norm();
  if (!rules_.limits.IsEmpty() &&
      !rules_.limits.AllowsSegment(grid_.Center(from), grid_.Center(to), rules_.position_error_m)) {
    return false;
  }
  const double bound = (ClearanceAt(from) + ClearanceAt(to) - length) / 2;
  if (bound >= rules_.ClearanceOfLine() + rules_.proof_tolerance_m) return true;
  return ProveClearance(free_space_.ray_scene(), grid_.Center(from), grid_.Center(to),
                        rules_.ClearanceOfLine(), rules_.proof_tolerance_m);
}

bool LegPlanner::IsSegmentProved(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
  if (grid_.AllOnSegment(a, b, [&](const Cell& cell) { return IsKnown(cell); })) {
    return WhyNotFly(free_space_, rules_in_known_space_, a, b).empty();
  }
  return WhyNotFly(free_space_, rules_, a, b).empty();
}

std::optional<Eigen::Vector3d> LegPlanner::NearestFreeCenter(
    const Eigen::Vector3d& point, int rings,
    const std::function<bool(const Eigen::Vector3d&)>& is_reachable) const {
  const Cell middle = grid_.CellAt(point);
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (int dz = -rings; dz <= rings; ++dz) {
    for (int dy = -rings; dy <= rings; ++dy) {
      for (int dx = -rings; dx <= rings; ++dx) {
        const Cell cell = middle + Cell(dx, dy, dz);
        if (!IsFree(cell)) continue;
        by_distance.emplace_back((grid_.Center(cell) - point).norm(), grid_.Index(cell));
      }
    }
  }
  std::sort(by_distance.begin(), by_distance.end());
  for (const auto& [distance, index] : by_distance) {
    const Eigen::Vector3d center = grid_.Center(grid_.FromIndex(index));
    if (is_reachable(center)) return center;
  }
  return std::nullopt;
}

std::vector<Eigen::Vector3d> LegPlanner::FindLeg(const Eigen::Vector3d& a,
                                                 const Eigen::Vector3d& b) const {
  if (IsSegmentProved(a, b)) return {a, b};
  const auto from = NearestFreeCenter(
      a, 1, [&](const Eigen::Vector3d& center) { return IsSegmentProved(a, center); });
  if (!from) return {};
  const auto to = NearestFreeCenter(
      b, 1, [&](const Eigen::Vector3d& center) { return IsSegmentProved(center, b); });
  if (!to) return {};
  const std::vector<Cell> cells = ShortestGridPath(
      grid_, grid_.CellAt(*from), grid_.CellAt(*to), [&](const Cell& cell) { return IsFree(cell); },
      [&](const Cell& c, const Cell& d) { return IsStepProved(c, d); });
  if (cells.empty()) return {};
  std::vector<Eigen::Vector3d> polyline = {a};
  for (const Cell& cell : cells) polyline.push_back(grid_.Center(cell));
  polyline.push_back(b);
  return PullStraight(polyline);
}

// From each corner to the furthest one that a proved segment reaches.
std::vector<Eigen::Vector3d> LegPlanner::PullStraight(
    const std::vector<Eigen::Vector3d>& polyline) const {
  std::vector<Eigen::Vector3d> pulled = {polyline.front()};
  std::size_t at = 0;
  while (at + 1 < polyline.size()) {
    std::size_t next = polyline.size() - 1;
    // The next corner itself was proved by the search.
    while (next > at + 1 && !IsSegmentProved(polyline[at], polyline[next])) --next;
    pulled.push_back(polyline[next]);
    at = next;
  }
  return pulled;
}

}  // namespace colmap_ext
