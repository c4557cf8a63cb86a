#include "path/tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace colmap_ext {
namespace {

Eigen::MatrixXd Distances(const std::vector<Eigen::Vector2d>& places) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd length(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      length(i, j) =
          (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(j)]).norm();
    }
  }
  return length;
}

double Length(const Eigen::MatrixXd& length, const std::vector<int>& tour) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < tour.size(); ++i) sum += length(tour[i], tour[i + 1]);
  return sum;
}

TEST(ShortOpenTour, IsNearlyTheShortestOfAllOrders) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(0, 10);
  double sum = 0, best_sum = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Eigen::Vector2d> places(7);
    for (auto& p : places) p << place(random), place(random);
    const Eigen::MatrixXd length = Distances(places);
    const std::vector<int> tour = ShortOpenTour(length);
    ASSERT_EQ(tour.size(), 7u);
    EXPECT_EQ(tour.front(), 0);
    std::vector<int> order(7);
    std::iota(order.begin(), order.end(), 0);
    EXPECT_TRUE(std::is_permutation(tour.begin(), tour.end(), order.begin()));
    double best = 1e9;
    do {
      best = std::min(best, Length(length, order));
    } while (std::next_permutation(order.begin() + 1, order.end()));
    EXPECT_LE(Length(length, tour), 1.4 * best);
    sum += Length(length, tour);
    best_sum += best;
  }
  EXPECT_LT(sum, 1.03 * best_sum);
}

TEST(ShortOpenTour, UndoesTheDetourOfTheNearestNeighbour) {
  // On a line: the nearest neighbour of 0 is 1, but -1.1 then 1 and 5 is shorter.
  const std::vector<int> tour = ShortOpenTour(Distances({{0, 0}, {1, 0}, {-1.1, 0}, {5, 0}}));
  EXPECT_EQ(tour, (std::vector<int>{0, 2, 1, 3}));
}

TEST(ShortOpenTour, HandlesNoneAndOne) {
  EXPECT_TRUE(ShortOpenTour(Eigen::MatrixXd(0, 0)).empty());
  EXPECT_EQ(ShortOpenTour(Eigen::MatrixXd::Zero(1, 1)), std::vector<int>{0});
}

}  // namespace
}  // namespace colmap_ext
