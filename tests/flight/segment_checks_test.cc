#include "colmap_ext/flight/segment_checks.h"

#include <gtest/gtest.h>

#include <random>

#include "path/box_world.h"

namespace colmap_ext {
namespace {

class Segments : public ::testing::Test {
 protected:
  Segments() : surface_(MeshOf({box_})) {
    space_.limits.fence = {{-30, -30}, {30, -30}, {30, 30}, {-30, 30}};
    space_.limits.min_relative_height_m = 2;
    space_.limits.max_relative_height_m = 50;
    space_.limits.max_distance_m = 100;
    space_.safe_distance_m = 4;
    space_.slack_m = 0.5;
    space_.surface = &surface_;
  }

  Eigen::AlignedBox3d box_{Eigen::Vector3d(-3, -3, 0), Eigen::Vector3d(3, 3, 8)};
  RayScene surface_;
  FlightSpace space_;
};

TEST_F(Segments, FreeSpaceIsAllowed) {
  EXPECT_EQ(CheckSegment(space_, {10, -10, 5}, {10, 10, 5}), "");
}

TEST_F(Segments, EachLimitIsNamed) {
  const Eigen::Vector3d from(10, -10, 5);
  EXPECT_NE(CheckSegment(space_, from, {10, 40, 5}).find("fence"), std::string::npos);
  EXPECT_NE(CheckSegment(space_, from, {10, 10, 1}).find("least height"), std::string::npos);
  EXPECT_NE(CheckSegment(space_, from, {10, 10, 60}).find("greatest height"), std::string::npos);
  EXPECT_NE(CheckSegment(space_, from, {-10, 10, 5}).find("surface"), std::string::npos);
  space_.limits.max_distance_m = 5;
  EXPECT_NE(CheckSegment(space_, from, {10, 10, 5}).find("distance"), std::string::npos);
  EXPECT_NE(CheckSegment(space_, from, {NAN, 10, 5}).find("finite"), std::string::npos);
}

TEST_F(Segments, AWayThroughANotchOfTheFenceIsRefused) {
  space_.surface = nullptr;
  space_.limits.fence = {{-30, -30}, {30, -30}, {30, 30}, {0, 0}, {-30, 30}};
  EXPECT_EQ(CheckSegment(space_, {-20, 10, 5}, {-20, -10, 5}), "");
  EXPECT_NE(CheckSegment(space_, {-20, 15, 5}, {20, 15, 5}).find("leaves the fence"),
            std::string::npos);
}

TEST_F(Segments, FromOutsideTheFenceTheWayBackIsAllowed) {
  EXPECT_EQ(CheckSegment(space_, {10, 40, 5}, {10, 20, 5}), "");
}

TEST_F(Segments, FromTooNearItMayLeaveButNotComeNearer) {
  EXPECT_EQ(CheckSegment(space_, {5, 0, 5}, {12, 0, 5}), "");
  EXPECT_NE(CheckSegment(space_, {5, 0, 5}, {-12, 0, 5}), "");
}

// Whatever is allowed keeps the distance, by sampling that does not use the code under test.
TEST_F(Segments, WhatIsAllowedIsClear) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> flat(-25, 25), high(3, 20);
  int allowed = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d from(flat(random), flat(random), high(random));
    const Eigen::Vector3d to(flat(random), flat(random), high(random));
    if (box_.exteriorDistance(from) < 4) continue;
    double least = 1e9;
    for (int k = 0; k <= 500; ++k) {
      least = std::min(least, box_.exteriorDistance(from + (to - from) * k / 500));
    }
    const bool is_allowed = CheckSegment(space_, from, to).empty();
    (is_allowed ? allowed : refused) += 1;
    if (is_allowed) {
      EXPECT_GT(least, 3.4);
    } else {
      EXPECT_LT(least, 3.7);
    }
  }
  EXPECT_GT(allowed, 50);
  EXPECT_GT(refused, 50);
}

TEST_F(Segments, ADetourGoesOverTheObstacle) {
  std::string complaint;
  const Eigen::Vector3d from(12, 0, 5), to(-12, 0, 6);
  EXPECT_TRUE(PlanLegs(space_, from, to, std::nullopt, false, &complaint).empty());
  EXPECT_NE(complaint, "");
  const auto legs = PlanLegs(space_, from, to, 15, false, &complaint);
  ASSERT_EQ(legs.size(), 3U) << complaint;
  EXPECT_EQ(legs[0], Eigen::Vector3d(12, 0, 15));
  EXPECT_EQ(legs[1], Eigen::Vector3d(-12, 0, 15));
  EXPECT_EQ(legs[2], to);
  EXPECT_TRUE(PlanLegs(space_, from, to, 10, false, &complaint).empty()) << "2 m above the roof";
}

TEST_F(Segments, InsideOfAPolygon) {
  const std::vector<Eigen::Vector2d> square = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  EXPECT_TRUE(IsInsidePolygon(square, {1, 1}));
  EXPECT_TRUE(IsInsidePolygon(square, {2, 1})) << "the border";
  EXPECT_TRUE(IsInsidePolygon(square, {0, 0})) << "a corner";
  EXPECT_FALSE(IsInsidePolygon(square, {3, 1}));
  EXPECT_FALSE(IsInsidePolygon(square, {-1, 0})) << "level with a corner";
}

TEST(BatteryNeeded, IsTimeByConsumption) {
  EXPECT_NEAR(BatteryNeeded({.way_m = 60, .hover_s = 30, .return_m = 30, .height_m = 60}, 3, 5),
              (20 + 30 + 10 + 60) / 60.0 * 5, 1e-12);
}

}  // namespace
}  // namespace colmap_ext
