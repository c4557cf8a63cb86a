#include "colmap_ext/path/grid_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <queue>
#include <random>
#include <set>

namespace colmap_ext {
namespace {

VoxelGrid Grid(int x, int y, int z) {
  return {Eigen::AlignedBox3d(Eigen::Vector3d::Zero(), Eigen::Vector3d(x, y, z)), 1.0};
}

double Cost(const std::vector<Cell>& path) {
  double cost = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    cost += (path[i + 1] - path[i]).cast<double>().norm();
  }
  return cost;
}

// Bellman-Ford over all cells, straight from the rules in the header; -1 where there is no way.
double CostByRelaxation(const VoxelGrid& grid, const std::vector<bool>& free, const Cell& start,
                        const Cell& goal) {
  std::vector<double> cost(grid.NumCells(), 1e300);
  cost[grid.Index(start)] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < grid.NumCells(); ++i) {
      const Cell cell = grid.FromIndex(i);
      for (int n = 0; n < 27; ++n) {
        const Cell next = cell + Cell(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        if (!grid.Contains(next)) continue;
        bool is_box_free = true;
        for (int k = 0; k < 8; ++k) {
          const Cell corner((k & 1) ? cell.x() : next.x(), (k & 2) ? cell.y() : next.y(),
                            (k & 4) ? cell.z() : next.z());
          is_box_free = is_box_free && free[grid.Index(corner)];
        }
        const double through = cost[grid.Index(cell)] + (next - cell).cast<double>().norm();
        if (is_box_free && through < cost[grid.Index(next)] - 1e-12) {
          cost[grid.Index(next)] = through;
          changed = true;
        }
      }
    }
  }
  return cost[grid.Index(goal)] > 1e299 ? -1 : cost[grid.Index(goal)];
}

TEST(ShortestGridPath, GoesAroundAWallOnTheKnownShortestWay) {
  // A wall at x = 4 from y = 0 to 6 in a single layer: down the free lane at y = 7 and back.
  const VoxelGrid grid = Grid(9, 8, 1);
  const auto is_free = [](const Cell& c) { return c.x() != 4 || c.y() == 7; };
  const std::vector<Cell> path = ShortestGridPath(grid, {0, 3, 0}, {8, 3, 0}, is_free);
  ASSERT_FALSE(path.empty());
  EXPECT_EQ(path.front(), Cell(0, 3, 0));
  EXPECT_EQ(path.back(), Cell(8, 3, 0));
  // To (3, 7): 3 diagonal steps and 1 straight; over (4, 7) to (5, 7): 2; and back the same.
  EXPECT_NEAR(Cost(path), 2 * (3 * std::sqrt(2.0) + 1) + 2, 1e-12);
}

TEST(ShortestGridPath, GoesStraightWhereAllIsFree) {
  const auto path =
      ShortestGridPath(Grid(10, 10, 10), {1, 1, 1}, {7, 5, 3}, [](const Cell&) { return true; });
  EXPECT_NEAR(Cost(path), 2 * std::sqrt(3.0) + 2 * std::sqrt(2.0) + 2, 1e-12);
}

TEST(ShortestGridPath, IsShortestAndNeverEntersAnOccupiedCellInRandomGrids) {
  std::mt19937 random(5);
  int solved = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const VoxelGrid grid = Grid(8, 7, 4);
    std::vector<bool> free(grid.NumCells());
    for (std::size_t i = 0; i < free.size(); ++i) free[i] = random() % 100 < 70;
    const Cell start(0, 0, 0), goal(7, 6, 3);
    free[grid.Index(start)] = free[grid.Index(goal)] = true;
    const auto path =
        ShortestGridPath(grid, start, goal, [&](const Cell& c) { return free[grid.Index(c)]; });
    const double best = CostByRelaxation(grid, free, start, goal);
    if (best < 0) {
      EXPECT_TRUE(path.empty()) << trial;
      continue;
    }
    ++solved;
    ASSERT_FALSE(path.empty()) << trial;
    EXPECT_NEAR(Cost(path), best, 1e-9) << trial;
    for (const Cell& cell : path) EXPECT_TRUE(free[grid.Index(cell)]) << trial;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      EXPECT_LE((path[i + 1] - path[i]).cwiseAbs().maxCoeff(), 1);
    }
  }
  EXPECT_GT(solved, 10);
}

TEST(ShortestGridPath, CutsNoCornersAndObeysForbiddenSteps) {
  const VoxelGrid grid = Grid(2, 2, 1);
  const auto one_corner = [](const Cell& c) { return c != Cell(1, 0, 0); };
  EXPECT_NEAR(Cost(ShortestGridPath(grid, {0, 0, 0}, {1, 1, 0}, one_corner)), 2, 1e-12);
  const auto all = [](const Cell&) { return true; };
  const auto no_diagonal = [](const Cell& a, const Cell& b) { return (a - b).squaredNorm() == 1; };
  EXPECT_NEAR(Cost(ShortestGridPath(grid, {0, 0, 0}, {1, 1, 0}, all, no_diagonal)), 2, 1e-12);
}

TEST(ShortestGridPath, HasNoPathFromOrToOccupiedOrOutsideCells) {
  const VoxelGrid grid = Grid(3, 1, 1);
  const auto first_occupied = [](const Cell& c) { return c.x() != 0; };
  EXPECT_TRUE(ShortestGridPath(grid, {0, 0, 0}, {2, 0, 0}, first_occupied).empty());
  EXPECT_TRUE(ShortestGridPath(grid, {2, 0, 0}, {0, 0, 0}, first_occupied).empty());
  EXPECT_TRUE(ShortestGridPath(grid, {2, 0, 0}, {3, 0, 0}, first_occupied).empty());
  EXPECT_EQ(ShortestGridPath(grid, {2, 0, 0}, {2, 0, 0}, first_occupied).size(), 1u);
}

TEST(VoxelGrid, CoversItsBoxAndFindsCells) {
  const VoxelGrid grid({Eigen::Vector3d(-1, 2, 0), Eigen::Vector3d(1.1, 3, 0.2)}, 0.5);
  EXPECT_EQ(grid.size(), Eigen::Vector3i(5, 2, 1));
  EXPECT_EQ(grid.CellAt({-1, 2, 0}), Cell(0, 0, 0));
  EXPECT_EQ(grid.CellAt({1.05, 2.6, 0.1}), Cell(4, 1, 0));
  for (std::size_t i = 0; i < grid.NumCells(); ++i) {
    EXPECT_EQ(grid.Index(grid.FromIndex(i)), i);
    EXPECT_EQ(grid.CellAt(grid.Center(grid.FromIndex(i))), grid.FromIndex(i));
  }
}

TEST(VoxelGrid, VisitsEveryCellThatASegmentTouches) {
  const VoxelGrid grid = Grid(10, 10, 10);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.5, 9.5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d a(place(random), place(random), place(random));
    const Eigen::Vector3d b(place(random), place(random), place(random));
    std::set<std::size_t> visited;
    EXPECT_TRUE(grid.AllOnSegment(a, b, [&](const Cell& cell) {
      visited.insert(grid.Index(cell));
      return true;
    }));
    std::set<std::size_t> sampled;
    for (int k = 0; k <= 20000; ++k) sampled.insert(grid.Index(grid.CellAt(a + (b - a) * k / 2e4)));
    // Sampling may miss a cell that is only grazed, the traversal must not.
    for (const std::size_t index : sampled) EXPECT_EQ(visited.count(index), 1u) << trial;
    EXPECT_LE(visited.size(), sampled.size() + 2) << trial;
  }
}

TEST(VoxelGrid, VisitsBothSidesOfAFaceAndStopsWhenTold) {
  const VoxelGrid grid = Grid(10, 10, 10);
  std::set<std::size_t> visited;
  const auto visit = [&](const Cell& cell) {
    visited.insert(grid.Index(cell));
    return true;
  };
  grid.AllOnSegment({2, 3.5, 3.5}, {2, 3.5, 3.5}, visit);
  EXPECT_EQ(visited.size(), 2u);
  visited.clear();
  grid.AllOnSegment({2.5, 4, 4}, {5.5, 4, 4}, visit);  // along an edge: four cells at a time
  EXPECT_EQ(visited.size(), 16u);
  EXPECT_FALSE(
      grid.AllOnSegment({0.5, 0.5, 0.5}, {8, 8, 8}, [](const Cell& c) { return c.x() < 3; }));
}

}  // namespace
}  // namespace colmap_ext
