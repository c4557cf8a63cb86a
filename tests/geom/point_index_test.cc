#include "colmap_ext/geom/point_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace colmap_ext {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(std::size_t count, double range, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-range, range);
  std::vector<Eigen::Vector3d> points(count);
  for (Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) point[k] = uniform(random);
  }
  return points;
}

TEST(PointIndex, AgreesWithExhaustiveSearch) {
  const auto points = RandomPoints(2000, 5, 1);
  const PointIndex index(points);
  for (const Eigen::Vector3d& query : RandomPoints(300, 8, 2)) {
    std::vector<double> distances;
    for (const Eigen::Vector3d& point : points) distances.push_back((point - query).norm());
    std::sort(distances.begin(), distances.end());
    const auto nearest = index.Nearest(query);
    ASSERT_TRUE(nearest);
    EXPECT_NEAR(nearest->distance, distances[0], 1e-12);
    EXPECT_FALSE(index.Nearest(query, 0.999 * distances[0]));
    EXPECT_TRUE(index.Nearest(query, 1.001 * distances[0]));
    const auto five = index.NearestOf(query, 5);
    ASSERT_EQ(five.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR(five[i].distance, distances[i], 1e-12);
      EXPECT_NEAR((points[static_cast<std::size_t>(five[i].index)] - query).norm(), distances[i],
                  1e-12);
    }
  }
}

TEST(PointIndex, NothingInNothing) {
  const PointIndex index({});
  EXPECT_FALSE(index.Nearest({0, 0, 0}));
  EXPECT_TRUE(index.NearestOf({0, 0, 0}, 3).empty());
  EXPECT_EQ(index.NumPoints(), 0u);
}

TEST(PointIndex, ManyEqualPointsAndFewerThanAskedFor) {
  const PointIndex index(std::vector<Eigen::Vector3d>(1000, Eigen::Vector3d(1, 2, 3)));
  EXPECT_EQ(index.Nearest({1, 2, 5})->distance, 2.0);
  const PointIndex two({{0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(two.NearestOf({0.9, 0, 0}, 10).size(), 2u);
  EXPECT_EQ(two.NearestOf({0.9, 0, 0}, 10).front().index, 1);
}

}  // namespace
}  // namespace colmap_ext
