#include "colmap_ext/mission/patterns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// About the size of the church.
RegionOfInterest Church() {
  RegionOfInterest region;
  region.box = BoundingBox(Eigen::Vector3d(-10, -6, 0), Eigen::Vector3d(10, 6, 19));
  return region;
}

double AngleBetween(const PlannedView& a, const PlannedView& b) {
  return std::acos(
      std::clamp(DirectionInWorld(a.direction).dot(DirectionInWorld(b.direction)), -1.0, 1.0));
}

TEST(InitialRectangle, LiesOnTheRectangleAtTheOffset) {
  const InitialFlightOptions options;
  const RegionOfInterest region = Church();
  const std::vector<PlannedView> views = InitialRectangle(region, options);
  ASSERT_EQ(views.size(), 64u);
  for (const PlannedView& view : views) {
    const double beyond_x = std::abs(view.position.x()) - 10;
    const double beyond_y = std::abs(view.position.y()) - 6;
    EXPECT_NEAR(std::max(beyond_x, beyond_y), options.offset_m, 1e-9) << view.id;
    EXPECT_DOUBLE_EQ(view.position.z(), InitialFlightHeight(region, options));
    EXPECT_NEAR(RadToDeg(view.direction.pitch_rad), -30, 1e-12);
  }
}

TEST(InitialRectangle, SpreadsViewsEvenlyAndClosesTheRound) {
  const std::vector<PlannedView> views = InitialRectangle(Church(), {});
  const double perimeter = 2 * (40 + 32);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Vector3d step = views[(i + 1) % views.size()].position - views[i].position;
    EXPECT_NEAR(step.lpNorm<1>(), perimeter / 64, 1e-9) << i;  // around a corner too
  }
}

TEST(InitialRectangle, NeighboursOverlapAndAllLookInward) {
  const std::vector<PlannedView> views = InitialRectangle(Church(), {});
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_LT(RadToDeg(AngleBetween(views[i], views[(i + 1) % views.size()])), 15.0 + 1e-9);
    // The horizontal ray of the heading hits the box.
    const double yaw = views[i].direction.yaw_rad;
    const Eigen::Vector2d heading(std::sin(yaw), std::cos(yaw));
    bool hits = false;
    for (double t = 0; t < 60; t += 0.05) {
      const Eigen::Vector2d p = views[i].position.head<2>() + t * heading;
      hits = hits || (std::abs(p.x()) <= 10 && std::abs(p.y()) <= 6);
    }
    EXPECT_TRUE(hits) << i;
  }
}

TEST(InitialRectangle, LooksInwardAtRightAnglesOnTheSides) {
  const std::vector<PlannedView> views = InitialRectangle(Church(), {});
  int at_right_angles = 0;
  for (const PlannedView& view : views) {
    if (std::abs(view.position.x()) > 10 || std::abs(view.position.y() + 16) > 1e-9) continue;
    EXPECT_NEAR(view.direction.yaw_rad, 0, 1e-9);  // south side: north
    ++at_right_angles;
  }
  EXPECT_GE(at_right_angles, 8);
}

TEST(InitialFlightHeight, CentresTheBoxOrStaysAboveItsTop) {
  InitialFlightOptions options;
  options.height_above_top_m = 0;
  options.offset_m = 20;
  // 9.5 + tan(30) (20 + 8), the mean half extent being 8.
  EXPECT_NEAR(InitialFlightHeight(Church(), options), 9.5 + 28 / std::sqrt(3.0), 1e-9);
  options.height_above_top_m = 30;
  EXPECT_NEAR(InitialFlightHeight(Church(), options), 49, 1e-9);
  options.height_m = 18;
  EXPECT_NEAR(InitialFlightHeight(Church(), options), 18, 1e-9);
}

TEST(InitialRectangle, TurnsOverWholeSidesWhenThereAreFewViews) {
  InitialFlightOptions options;
  options.num_views = 8;
  const std::vector<PlannedView> views = InitialRectangle(Church(), options);
  ASSERT_EQ(views.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_LT(RadToDeg(AngleBetween(views[i], views[(i + 1) % 8])), 60) << i;
  }
}

TEST(InitialRectangle, RefusesBadInput) {
  InitialFlightOptions options;
  options.num_views = 3;
  EXPECT_THROW(InitialRectangle(Church(), options), UsageError);
  options = {};
  options.offset_m = 0;
  EXPECT_THROW(InitialRectangle(Church(), options), UsageError);
  EXPECT_THROW(InitialRectangle(RegionOfInterest{}, {}), Error);
}

TEST(PathInOrder, AddsUpLengthAndTime) {
  const std::vector<PlannedView> views = InitialRectangle(Church(), {});
  const FlightPath path = PathInOrder(views, 2, 3);
  ASSERT_EQ(path.waypoints.size(), 64u);
  EXPECT_EQ(path.waypoints[5].view_id, 5);
  EXPECT_LE(path.length_m, 144 * 63.0 / 64 + 1e-9);
  EXPECT_GT(path.length_m, 135);
  EXPECT_NEAR(path.duration_s, path.length_m / 2 + 64 * 3, 1e-9);
}

}  // namespace
}  // namespace colmap_ext
