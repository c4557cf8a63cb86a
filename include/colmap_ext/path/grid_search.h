// A regular grid of cubes, and exact shortest paths on it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <vector>

namespace colmap_ext {

using Cell = Eigen::Vector3i;

// Cubic cells that fill a box of the world.
class VoxelGrid {
 public:
  VoxelGrid() = default;
  // Cells of `cell_size_m` > 0 from box.min() on, as many as are needed to cover the box (at least
  // one an axis).
  VoxelGrid(const Eigen::AlignedBox3d& box, double cell_size_m);

  double cell_size_m() const { return cell_size_m_; }
  const Eigen::Vector3i& size() const { return size_; }
  std::size_t NumCells() const {
    return static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) *
           static_cast<std::size_t>(size_.z());
  }
  bool Contains(const Cell& cell) const {
    return (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
  }
  Cell CellAt(const Eigen::Vector3d& point) const;  // may lie outside the grid
  Eigen::Vector3d Center(const Cell& cell) const;
  // Position of the cell in arrays over the grid: x runs fastest.
  std::size_t Index(const Cell& cell) const {
    return (static_cast<std::size_t>(cell.z()) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(cell.y())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(cell.x());
  }
  Cell FromIndex(std::size_t index) const;

  // Calls `visit` for every cell that the closed segment touches, those touched at an edge or
  // corner included (within 1e-9 cells), until it returns false; then returns false. Cells outside
  // the grid are visited too.
  bool AllOnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    const std::function<bool(const Cell&)>& visit) const;

 private:
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double cell_size_m_ = 1;
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
};

// Shortest path by A* between two free cells over the 26 neighbours, steps costing 1, sqrt(2) and
// sqrt(3) cells (the heuristic is the free-space distance with these steps, which never
// overestimates). A diagonal step needs all cells of the box that it crosses to be free: no corner
// is cut. `is_step_free` may forbid more steps (it must be symmetric; null: none). Returns the
// cells from start to goal, both included; empty when there is no way. Equal paths are decided by
// cell index: one result always.
std::vector<Cell> ShortestGridPath(
    const VoxelGrid& grid, const Cell& start, const Cell& goal,
    const std::function<bool(const Cell&)>& is_free,
    const std::function<bool(const Cell&, const Cell&)>& is_step_free = nullptr);

}  // namespace colmap_ext
