#include "colmap_ext/path/grid_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <unordered_map>

namespace colmap_ext {
namespace {

// Least cost between cells when everything is free: as many diagonal steps as possible.
double FreeCost(const Cell& from, const Cell& to) {
  std::array<int, 3> d = {std::abs(to.x() - from.x()), std::abs(to.y() - from.y()),
                          std::abs(to.z() - from.z())};
  std::sort(d.begin(), d.end());
  return std::sqrt(3.0) * d[0] + std::sqrt(2.0) * (d[1] - d[0]) + (d[2] - d[1]);
}

struct OpenCell {
  double estimate = 0;  // cost so far + free cost to the goal
  double cost = 0;
  std::size_t index = 0;
  // std::priority_queue takes the largest first.
  bool operator<(const OpenCell& other) const {
    if (estimate != other.estimate) return estimate > other.estimate;
    return index > other.index;
  }
};

struct Reached {
  double cost = 0;
  std::size_t parent = 0;
  bool closed = false;
};

// All cells of the box that the step spans are free (both ends are known to be inside the grid).
bool IsBoxFree(const Cell& from, const Cell& to, const std::function<bool(const Cell&)>& is_free) {
  const Cell low = from.cwiseMin(to);
  const Cell high = from.cwiseMax(to);
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        if (!is_free(Cell(x, y, z))) return false;
      }
    }
  }
  return true;
}

// Visits the cells that a point (in cells) lies in: more than one on a face, edge or corner.
bool VisitAround(const Eigen::Vector3d& point, const std::function<bool(const Cell&)>& visit) {
  constexpr double kTolerance = 1e-9;
  const Cell low = (point.array() - kTolerance).floor().cast<int>();
  const Cell high = (point.array() + kTolerance).floor().cast<int>();
  return IsBoxFree(low, high, visit);
}

class GridSearch {
 public:
  GridSearch(const VoxelGrid& grid, const Cell& goal,
             const std::function<bool(const Cell&)>& is_free,
             const std::function<bool(const Cell&, const Cell&)>& is_step_free)
      : grid_(grid), goal_(goal), is_free_(is_free), is_step_free_(is_step_free) {}

  std::vector<Cell> Run(const Cell& start) {
    const std::size_t start_index = grid_.Index(start);
    const std::size_t goal_index = grid_.Index(goal_);
    reached_[start_index] = {0, start_index, false};
    open_.push({FreeCost(start, goal_), 0, start_index});
    while (!open_.empty()) {
      const OpenCell best = open_.top();
      open_.pop();
      Reached& reached = reached_[best.index];
      if (reached.closed) continue;  // an older, dearer entry
      reached.closed = true;
      if (best.index == goal_index) return WayBack(start_index, goal_index);
      Expand(best);
    }
    return {};
  }

 private:
  void Expand(const OpenCell& from) {
    const Cell cell = grid_.FromIndex(from.index);
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx != 0 || dy != 0 || dz != 0) TryStep(from, cell, cell + Cell(dx, dy, dz));
        }
      }
    }
  }

  void TryStep(const OpenCell& from, const Cell& cell, const Cell& next) {
    if (!grid_.Contains(next)) return;
    const std::size_t index = grid_.Index(next);
    const double cost = from.cost + std::sqrt((next - cell).squaredNorm());
    const auto known = reached_.find(index);
    if (known != reached_.end() && (known->second.closed || known->second.cost <= cost)) return;
    if (!IsBoxFree(cell, next, is_free_)) return;
    if (is_step_free_ && !is_step_free_(cell, next)) return;
    reached_[index] = {cost, from.index, false};
    open_.push({cost + FreeCost(next, goal_), cost, index});
  }

  std::vector<Cell> WayBack(std::size_t start, std::size_t goal) const {
    std::vector<Cell> path = {grid_.FromIndex(goal)};
    for (std::size_t at = goal; at != start; path.push_back(grid_.FromIndex(at))) {
      at = reached_.at(at).parent;
    }
    std::reverse(path.begin(), path.end());
    return path;
  }

  const VoxelGrid& grid_;
  Cell goal_;
  const std::function<bool(const Cell&)>& is_free_;
  const std::function<bool(const Cell&, const Cell&)>& is_step_free_;
  std::priority_queue<OpenCell> open_;
  std::unordered_map<std::size_t, Reached> reached_;
};

}  // namespace

VoxelGrid::VoxelGrid(const Eigen::AlignedBox3d& box, double cell_size_m)
    : origin_(box.min()), cell_size_m_(cell_size_m) {
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = std::max(1, static_cast<int>(std::ceil(box.sizes()[axis] / cell_size_m - 1e-9)));
  }
}

Cell VoxelGrid::CellAt(const Eigen::Vector3d& point) const {
  return ((point - origin_) / cell_size_m_).array().floor().cast<int>();
}

Eigen::Vector3d VoxelGrid::Center(const Cell& cell) const {
  return origin_ + cell_size_m_ * (cell.cast<double>() + Eigen::Vector3d::Constant(0.5));
}

Cell VoxelGrid::FromIndex(std::size_t index) const {
  const auto width = static_cast<std::size_t>(size_.x());
  const auto depth = static_cast<std::size_t>(size_.y());
  return {static_cast<int>(index % width), static_cast<int>(index / width % depth),
          static_cast<int>(index / width / depth)};
}

bool VoxelGrid::AllOnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const std::function<bool(const Cell&)>& visit) const {
  const Eigen::Vector3d from = (a - origin_) / cell_size_m_;
  const Eigen::Vector3d step = (b - a) / cell_size_m_;
  // Between two neighbouring cuts at the grid's planes the cells do not change.
  std::vector<double> cuts = {0, 1};
  for (int axis = 0; axis < 3; ++axis) {
    if (step[axis] == 0) continue;
    const double low = std::min(from[axis], from[axis] + step[axis]);
    const double high = std::max(from[axis], from[axis] + step[axis]);
    for (double plane = std::ceil(low); plane <= high; plane += 1) {
      cuts.push_back(std::clamp((plane - from[axis]) / step[axis], 0.0, 1.0));
    }
  }
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (!VisitAround(from + cuts[i] * step, visit)) return false;
    if (i + 1 == cuts.size()) break;
    if (!VisitAround(from + (cuts[i] + cuts[i + 1]) / 2 * step, visit)) return false;
  }
  return true;
}

std::vector<Cell> ShortestGridPath(
    const VoxelGrid& grid, const Cell& start, const Cell& goal,
    const std::function<bool(const Cell&)>& is_free,
    const std::function<bool(const Cell&, const Cell&)>& is_step_free) {
  if (!grid.Contains(start) || !grid.Contains(goal) || !is_free(start) || !is_free(goal)) return {};
  return GridSearch(grid, goal, is_free, is_step_free).Run(start);
}

}  // namespace colmap_ext
