#include "mvs/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

namespace colmap_ext {
namespace {

// A random matrix whose blocks are those of a graph, each node with up to `degree` neighbours;
// positive definite by a large diagonal. Columns in the order of minimum degree.
struct RandomSystem {
  RandomSystem(int n, int degree, unsigned seed) : random(seed) {
    std::vector<std::vector<int>> adjacency(static_cast<std::size_t>(n));
    const auto link = [&](int a, int b) {
      std::vector<int>& of_a = adjacency[static_cast<std::size_t>(a)];
      if (a == b || std::find(of_a.begin(), of_a.end(), b) != of_a.end()) return;
      of_a.push_back(b);
      adjacency[static_cast<std::size_t>(b)].push_back(a);
    };
    for (int i = 0; i < n * degree / 2; ++i) link(Index(n), Index(n));
    order = MinimumDegreeOrder(adjacency);
    std::vector<int> position(order.size());
    for (std::size_t p = 0; p < order.size(); ++p) {
      position[static_cast<std::size_t>(order[p])] = static_cast<int>(p);
    }
    dense.setZero(3 * n, 3 * n);
    for (int p = 0; p < n; ++p) {
      std::vector<int> rows;
      for (const int j : adjacency[static_cast<std::size_t>(order[static_cast<std::size_t>(p)])]) {
        if (position[static_cast<std::size_t>(j)] > p) {
          rows.push_back(position[static_cast<std::size_t>(j)]);
        }
      }
      std::sort(rows.begin(), rows.end());
      for (const int row : rows) {
        const Eigen::Matrix3d block = Eigen::Matrix3d::NullaryExpr([&] { return Number(); });
        blocks.row.push_back(row);
        blocks.block.push_back(block);
        dense.block<3, 3>(3 * row, 3 * p) = block;
        dense.block<3, 3>(3 * p, 3 * row) = block.transpose();
      }
      blocks.begin.push_back(static_cast<int>(blocks.row.size()));
      const Eigen::Matrix3d half = Eigen::Matrix3d::NullaryExpr([&] { return Number(); });
      blocks.diagonal.push_back(half * half.transpose() +
                                4.0 * degree * Eigen::Matrix3d::Identity());
      dense.block<3, 3>(3 * p, 3 * p) = blocks.diagonal.back();
    }
  }
  int Index(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }
  double Number() { return std::uniform_real_distribution<double>(-1, 1)(random); }

  double Residual(const BlockCholesky& factor) {
    std::vector<Eigen::Vector3d> x(blocks.diagonal.size());
    for (Eigen::Vector3d& v : x) v = {Number(), Number(), Number()};
    Eigen::VectorXd b(dense.rows());
    for (std::size_t i = 0; i < x.size(); ++i) b.segment<3>(3 * static_cast<long>(i)) = x[i];
    factor.Solve(&x);
    Eigen::VectorXd solution(dense.rows());
    for (std::size_t i = 0; i < x.size(); ++i) {
      solution.segment<3>(3 * static_cast<long>(i)) = x[i];
    }
    return (dense * solution - b).norm() / b.norm();
  }

  std::mt19937 random;
  std::vector<int> order;
  BlockColumns blocks;
  Eigen::MatrixXd dense;
};

TEST(BlockCholesky, SolvesWhatADenseMatrixSays) {
  for (const int n : {1, 2, 5, 40, 150}) {
    for (const int degree : {1, 3, 6}) {
      RandomSystem system(n, degree, static_cast<unsigned>(n + degree));
      BlockCholesky factor(system.blocks);
      ASSERT_TRUE(factor.Factor(system.blocks)) << n;
      EXPECT_LT(system.Residual(factor), 1e-12) << n << ' ' << degree;
    }
  }
}

TEST(BlockCholesky, OneAnalysisServesManyFactorisations) {
  RandomSystem system(80, 3, 1);
  BlockCholesky factor(system.blocks);
  ASSERT_TRUE(factor.Factor(system.blocks));
  for (Eigen::Matrix3d& block : system.blocks.diagonal) block += Eigen::Matrix3d::Identity();
  system.dense += Eigen::MatrixXd::Identity(system.dense.rows(), system.dense.cols());
  ASSERT_TRUE(factor.Factor(system.blocks));
  EXPECT_LT(system.Residual(factor), 1e-12);
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  RandomSystem system(20, 3, 2);
  BlockCholesky factor(system.blocks);
  system.blocks.diagonal[11](1, 1) = -1;
  EXPECT_FALSE(factor.Factor(system.blocks));
  system.blocks.diagonal[11](1, 1) = std::nan("");
  EXPECT_FALSE(factor.Factor(system.blocks));
}

TEST(BlockCholesky, NothingToSolveIsNoError) {
  BlockCholesky factor{BlockColumns()};
  EXPECT_TRUE(factor.Factor(BlockColumns()));
  std::vector<Eigen::Vector3d> x;
  factor.Solve(&x);
}

TEST(MinimumDegreeOrder, IsAPermutationThatKeepsAStarSparse) {
  // A star's centre must not go before its last ray but one, or all rays would be joined.
  std::vector<std::vector<int>> star(9);
  for (int i = 1; i < 9; ++i) {
    star[0].push_back(i);
    star[static_cast<std::size_t>(i)].push_back(0);
  }
  std::vector<int> order = MinimumDegreeOrder(star);
  EXPECT_GE(std::find(order.begin(), order.end(), 0) - order.begin(), 7);
  std::sort(order.begin(), order.end());
  for (int i = 0; i < 9; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace colmap_ext
