#include "colmap_ext/geom/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace colmap_ext {
namespace {

const PolygonRing kSquare = {{-2, -2}, {2, -2}, {2, 2}, {-2, 2}};
const PolygonRing kEll = {{0, 0}, {20, 0}, {20, 10}, {10, 10}, {10, 20}, {0, 20}};

TEST(Polygon, InsideAndOutside) {
  EXPECT_TRUE(IsInsideRing(kSquare, {1, 1}));
  EXPECT_FALSE(IsInsideRing(kSquare, {3, 1}));
  EXPECT_FALSE(IsInsideRing(kSquare, {-3, 2})) << "level with corners";
  EXPECT_FALSE(IsInsideRing(kEll, {15, 15})) << "the notch";
  EXPECT_FALSE(IsInsideRing({}, {0, 0}));
  EXPECT_FALSE(IsInsideRing({{-1, -1}, {1, 1}}, {0, 0}));
}

TEST(Polygon, ADiskByItsRadius) {
  PolygonRing circle;
  for (int i = 0; i < 720; ++i) {
    circle.emplace_back(5 * std::cos(i * M_PI / 360), 5 * std::sin(i * M_PI / 360));
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-8, 8);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d point(at(random), at(random));
    if (std::abs(point.norm() - 5) < 1e-3) continue;
    EXPECT_EQ(IsInsideRing(circle, point), point.norm() < 5) << point.transpose();
    EXPECT_NEAR(DistanceToBorder(circle, point), std::abs(point.norm() - 5), 2e-4);
  }
}

TEST(Polygon, HolesAndIslandsNeedNoOrder) {
  const PolygonRing hole = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const PolygonRing island = {{-0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}};
  const std::vector<std::vector<PolygonRing>> orders = {{kSquare, hole, island},
                                                        {island, kSquare, hole}};
  for (const std::vector<PolygonRing>& rings : orders) {
    EXPECT_TRUE(IsInsideRings(rings, {1.5, 0}));
    EXPECT_FALSE(IsInsideRings(rings, {0.75, 0}));
    EXPECT_TRUE(IsInsideRings(rings, {0, 0}));
    EXPECT_FALSE(IsInsideRings(rings, {5, 0}));
  }
  EXPECT_FALSE(IsInsideRings({}, {0, 0}));
}

TEST(Polygon, DistanceToItsEdges) {
  EXPECT_DOUBLE_EQ(DistanceToBorder(kSquare, {0, 1.5}), 0.5);
  EXPECT_DOUBLE_EQ(DistanceToBorder(kSquare, {5, 6}), 5) << "a corner is nearest";
  EXPECT_DOUBLE_EQ(DistanceToBorder(kSquare, {-2, 0.3}), 0) << "the edge that closes the ring";
  EXPECT_DOUBLE_EQ(DistanceToBorder({{1, 1}, {1, 1}}, {1, 3}), 2) << "an edge without length";
  EXPECT_EQ(DistanceToBorder({}, {0, 0}), std::numeric_limits<double>::infinity());
}

TEST(Polygon, AreaHasTheSignOfItsTurn) {
  EXPECT_DOUBLE_EQ(SignedArea(kSquare), 16);
  EXPECT_DOUBLE_EQ(SignedArea({kSquare.rbegin(), kSquare.rend()}), -16);
  EXPECT_DOUBLE_EQ(SignedArea(kEll), 300);
  EXPECT_DOUBLE_EQ(SignedArea({}), 0);
}

}  // namespace
}  // namespace colmap_ext
