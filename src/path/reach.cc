#include <algorithm>
#include <mutex>
#include <optional>
#include <queue>
#include <unordered_map>
#include <vector>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/util/error.h"
#include "path/leave_start.h"
#include "path/leg_planner.h"

namespace colmap_ext {
namespace {

// Around surface and flown places, with room for detours; ways do not lead below what is there.
Eigen::AlignedBox3d ReachBox(const FreeSpace& space, const Eigen::Vector3d& start,
                             const PathOptions& options) {
  Eigen::AlignedBox3d box = space.Bounds();
  box.extend(start);
  const double floor_m = box.min().z() - options.cell_size_m;
  const double margin_m = options.detour_margin_m + options.safe_distance_m +
                          options.position_error_m + 2 * options.cell_size_m;
  box = Eigen::AlignedBox3d(box.min().array() - margin_m, box.max().array() + margin_m);
  box.min().z() = floor_m;
  return box;
}

// Which cells are joined to the start. Every cell is expanded once, whatever is asked how often: a
// search ends where one before it was.
class Reach {
 public:
  Reach(std::shared_ptr<const FreeSpace> space, const Eigen::Vector3d& start,
        const PathOptions& options)
      : space_(std::move(space)),
        box_(ReachBox(*space_, start, options)),
        detour_margin_m_(options.detour_margin_m),
        legs_(*space_, RulesOf(options), box_, options.cell_size_m) {
    try {
      start_ = LeaveStart(legs_, start, options, JobControl()).back();
    } catch (const Error&) {
      return;
    }
    const auto center = legs_.NearestFreeCenter(*start_, 1, [&](const Eigen::Vector3d& cell) {
      return legs_.IsSegmentProved(*start_, cell);
    });
    if (center) Join(legs_.grid().CellAt(*center));
  }

  bool LeadsTo(const Eigen::Vector3d& place) {
    if (!start_) return true;
    const std::lock_guard lock(mutex_);
    if (legs_.IsSegmentProved(*start_, place)) return true;
    if (!legs_.grid().Contains(legs_.grid().CellAt(place))) return LeadsOut(place);
    const auto center = legs_.NearestFreeCenter(
        place, 1, [&](const Eigen::Vector3d& cell) { return legs_.IsSegmentProved(cell, place); });
    return center && origin_ && IsJoined(legs_.grid().CellAt(*center));
  }

 private:
  // To a place beyond the grid: a search of its own.
  bool LeadsOut(const Eigen::Vector3d& place) const {
    Eigen::AlignedBox3d box = box_;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(detour_margin_m_);
    box.extend(Eigen::AlignedBox3d(place - margin, place + margin));
    const LegPlanner legs(*space_, legs_.rules(), box, legs_.grid().cell_size_m());
    return !legs.FindLeg(*start_, place).empty();
  }

  void Join(const Cell& cell) {
    origin_ = cell;
    is_joined_[legs_.grid().Index(cell)] = true;
  }

  // Best-first towards the start, by steps along the axes (a diagonal step needs the cells of its
  // box to be free, so they are joined without it, too).
  bool IsJoined(const Cell& from) {
    const VoxelGrid& grid = legs_.grid();
    const auto known = is_joined_.find(grid.Index(from));
    if (known != is_joined_.end()) return known->second;
    using Open = std::pair<int, std::size_t>;  // squared distance to the start's cell, index
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    std::vector<std::size_t> reached;
    const auto add = [&](const Cell& cell) {
      is_joined_[grid.Index(cell)] = false;  // until the search meets what is joined
      reached.push_back(grid.Index(cell));
      open.emplace((cell - *origin_).squaredNorm(), grid.Index(cell));
    };
    add(from);
    bool is_joined = false;
    while (!open.empty() && !is_joined) {
      const Cell cell = grid.FromIndex(open.top().second);
      open.pop();
      for (int side = 0; side < 6 && !is_joined; ++side) {
        Cell next = cell;
        next[side / 2] += side % 2 == 0 ? 1 : -1;
        if (!grid.Contains(next)) continue;
        const auto seen = is_joined_.find(grid.Index(next));
        // Of an earlier search that failed nothing is left to be met here: it went on to its end.
        if (seen != is_joined_.end() && !seen->second) continue;
        if (!legs_.IsFree(next) || !legs_.IsStepProved(cell, next)) continue;
        if (seen != is_joined_.end()) {
          is_joined = true;
        } else {
          add(next);
        }
      }
    }
    if (is_joined) {
      for (const std::size_t index : reached) is_joined_[index] = true;
    }
    return is_joined;
  }

  std::shared_ptr<const FreeSpace> space_;
  Eigen::AlignedBox3d box_;
  double detour_margin_m_;
  LegPlanner legs_;
  std::optional<Eigen::Vector3d> start_;  // absent: it may not be left
  std::optional<Cell> origin_;            // a free cell beside it
  std::unordered_map<std::size_t, bool> is_joined_;
  std::mutex mutex_;
};

}  // namespace

std::function<bool(const Eigen::Vector3d&)> ReachablePositions(
    std::shared_ptr<const FreeSpace> space, const Eigen::Vector3d& start,
    const PathOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!start.allFinite()) throw Error("path: the start position is not finite");
  return [reach = std::make_shared<Reach>(std::move(space), start, options)](
             const Eigen::Vector3d& place) { return reach->LeadsTo(place); };
}

}  // namespace colmap_ext
