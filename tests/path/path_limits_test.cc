// Paths under limits: fence, no-fly zone, position error, battery, and inputs at the edge.
#include <gtest/gtest.h>

#include <cmath>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/util/error.h"
#include "path/box_world.h"

namespace colmap_ext {
namespace {

PathOptions OnOneBattery() {
  PathOptions options = Everywhere();
  options.battery_s = 0;
  return options;
}

FlightZone Rectangle(FlightZone::Kind kind, double x0, double y0, double x1, double y1) {
  FlightZone zone;
  zone.kind = kind;
  zone.rings = {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}};
  return zone;
}

TEST(PlanPath, KeepsThePositionErrorOnTopOfTheSafeDistance) {
  PathOptions options = OnOneBattery();
  options.position_error_m = 1;
  const FlightPath path = PlanPath({-20, 0, 5}, {ViewAt(0, 20, 0, 5), ViewAt(1, -7.5, 0, 5)},
                                   MeshOf(kBlock), {}, options, {});
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), 3 - 1e-4);
  EXPECT_GE(path.min_clearance_m, 2 - 0.03);
  EXPECT_LE(path.min_clearance_m, SampledClearance(kBlock, path.waypoints) - 1 + 1e-6);
  EXPECT_EQ(path.dropped_view_ids, std::vector<int>{1});
  EXPECT_TRUE(Says(path.drop_reasons.at(0), "2.50 m from the surface"));
}

TEST(PlanPath, FliesAroundANoFlyZoneAndStaysInsideTheFence) {
  PathOptions options = OnOneBattery();
  options.limits.zones = {Rectangle(FlightZone::Kind::kInclusion, -30, -30, 30, 30),
                          Rectangle(FlightZone::Kind::kExclusion, -3, -28, 3, -8)};
  const FlightPath path =
      PlanPath({-20, -20, 5}, {ViewAt(0, 20, -20, 5), ViewAt(1, 0, -15, 5), ViewAt(2, 31, 0, 5)},
               MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(path.dropped_view_ids, (std::vector<int>{1, 2}));
  EXPECT_TRUE(Says(path.drop_reasons.at(0), "no-fly"));
  EXPECT_TRUE(Says(path.drop_reasons.at(1), "geofence"));
  ASSERT_GT(path.waypoints.size(), 2u);
  for (std::size_t i = 0; i + 1 < path.waypoints.size(); ++i) {
    const Eigen::Vector3d& a = path.waypoints[i].position;
    const Eigen::Vector3d& b = path.waypoints[i + 1].position;
    for (int k = 0; k <= 1000; ++k) {
      const Eigen::Vector3d p = a + (b - a) * k / 1000.0;
      EXPECT_FALSE(std::abs(p.x()) < 3 && p.y() > -28 && p.y() < -8);
      EXPECT_LE(p.head<2>().cwiseAbs().maxCoeff(), 30);
    }
  }
}

TEST(PlanPath, AFenceThatExcludesTheStartIsAnErrorThatSaysSo) {
  PathOptions options = OnOneBattery();
  options.limits.zones = {Rectangle(FlightZone::Kind::kInclusion, 100, 100, 130, 130)};
  try {
    PlanPath({-20, 0, 5}, {ViewAt(0, -20, 5, 5)}, MeshOf(kBlock), {}, options, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_TRUE(Says(error.what(), "geofence")) << error.what();
  }
}

// Its walls are further away than the safe distance.
TEST(PlanPath, RefusesAStartInsideOfALargeObstacle) {
  EXPECT_THROW(PlanPath({0, 0, 5}, {ViewAt(0, 1, 0, 5)}, MeshOf(kBlock), {}, OnOneBattery(), {}),
               Error);
}

TEST(PlanPath, AFenceThatExcludesAllViewsLeavesThePathEmptyWithReasons) {
  PathOptions options = OnOneBattery();
  options.limits.zones = {Rectangle(FlightZone::Kind::kInclusion, -25, -2, -15, 2)};
  const FlightPath path = PlanPath({-20, 0, 5}, {ViewAt(0, 20, 0, 5), ViewAt(1, 0, 20, 5)},
                                   MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(path.waypoints.size(), 1u);
  EXPECT_EQ(path.dropped_view_ids, (std::vector<int>{0, 1}));
  for (const std::string& reason : path.drop_reasons) EXPECT_TRUE(Says(reason, "geofence"));
}

TEST(PlanPath, SaysWhyNoWayLeadsToAView) {
  // A closed room of 4 m, its walls 1 m thick, around the view.
  std::vector<Eigen::AlignedBox3d> room = {{Eigen::Vector3d(-6, -6, -1), Eigen::Vector3d(6, 6, 0)},
                                           {Eigen::Vector3d(-6, -6, 8), Eigen::Vector3d(6, 6, 9)},
                                           {Eigen::Vector3d(-6, -6, 0), Eigen::Vector3d(-5, 6, 8)},
                                           {Eigen::Vector3d(5, -6, 0), Eigen::Vector3d(6, 6, 8)},
                                           {Eigen::Vector3d(-6, -6, 0), Eigen::Vector3d(6, -5, 8)},
                                           {Eigen::Vector3d(-6, 5, 0), Eigen::Vector3d(6, 6, 8)}};
  const FlightPath path =
      PlanPath({-20, 0, 4}, {ViewAt(7, 0, 0, 4)}, MeshOf(room), {}, OnOneBattery(), {});
  EXPECT_EQ(path.dropped_view_ids, std::vector<int>{7});
  EXPECT_TRUE(Says(path.drop_reasons.at(0), "no way")) << path.drop_reasons.at(0);
  EXPECT_TRUE(Says(path.drop_reasons.at(0), "surface")) << path.drop_reasons.at(0);
}

std::vector<PlannedView> Around(int count, double radius) {
  std::vector<PlannedView> views;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    views.push_back(ViewAt(i, radius * std::cos(angle), radius * std::sin(angle), 5));
  }
  return views;
}

TEST(PlanPath, SplitsIntoBatteriesWithProvedWaysHome) {
  PathOptions options = OnOneBattery();
  options.battery_s = 150;
  options.takeoff_landing_s = 10;
  const Eigen::Vector3d start(-14, -14, 5);
  const FlightPath path = PlanPath(start, Around(16, 14), MeshOf(kBlock), {}, options, {});
  ASSERT_GT(path.flights.size(), 1u);
  EXPECT_TRUE(path.dropped_view_ids.empty());
  for (std::size_t i = 0; i < path.flights.size(); ++i) {
    const BatteryFlight& flight = path.flights[i];
    EXPECT_LE(flight.battery_share, 0.75 + 1e-9) << i;
    EXPECT_EQ(path.waypoints[flight.first_waypoint].position, start) << i;
    if (i > 0) {
      EXPECT_EQ(path.flights[i - 1].last_waypoint, flight.first_waypoint);
    }
  }
  EXPECT_EQ(path.flights.back().last_waypoint + 1, path.waypoints.size());
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), 2 - 1e-4);  // ways home included
  int photos = 0;
  for (const Waypoint& waypoint : path.waypoints) photos += waypoint.view_id >= 0 ? 1 : 0;
  EXPECT_EQ(photos, 16);
}

TEST(PlanPath, ReturnsHomeWhenAsked) {
  PathOptions options = OnOneBattery();
  options.home = "20,0,5";
  options.return_home = true;
  const FlightPath path =
      PlanPath({-20, 0, 5}, {ViewAt(0, -20, 10, 5)}, MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(path.waypoints.back().position, Eigen::Vector3d(20, 0, 5));
  EXPECT_EQ(path.waypoints.back().view_id, -1);
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), 2 - 1e-4);
  options.home = "0,0,5";  // in the block
  EXPECT_THROW(PlanPath({-20, 0, 5}, {ViewAt(0, -20, 10, 5)}, MeshOf(kBlock), {}, options, {}),
               Error);
  options.home = "somewhere";
  EXPECT_THROW(PlanPath({-20, 0, 5}, {}, MeshOf(kBlock), {}, options, {}), UsageError);
}

TEST(PlanPath, DropsWhatABatteryCannotReach) {
  PathOptions options = OnOneBattery();
  options.battery_s = 100;
  options.takeoff_landing_s = 10;
  const FlightPath path = PlanPath({-20, 0, 5}, {ViewAt(0, -20, 20, 5), ViewAt(1, -20, 300, 5)},
                                   MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(path.dropped_view_ids, std::vector<int>{1});
  EXPECT_TRUE(Says(path.drop_reasons.at(0), "battery"));
}

// More places than direct legs are looked for between all of.
TEST(PlanPath, JoinsManyViewsInAReasonableTour) {
  const std::vector<PlannedView> views = Around(90, 15);
  const FlightPath path = PlanPath({-20, 0, 5}, views, MeshOf(kBlock), {}, OnOneBattery(), {});
  EXPECT_TRUE(path.dropped_view_ids.empty());
  EXPECT_LT(path.length_m, 5 + 2 * M_PI * 15 + 8);
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), 2 - 1e-4);
}

TEST(PlanPath, IsTheSameBySharedSpaceAndHoversWhereFlyablePositionsSays) {
  PathOptions options = OnOneBattery();
  const Eigen::Vector3d start(-20, 0, 5);
  const auto space =
      std::make_shared<const FreeSpace>(KnownSpace(SurfaceOf(kBlock), {}, start, options));
  const std::vector<PlannedView> views = Around(6, 12);
  const FlightPath shared = PlanPath(start, views, *space, options, {});
  const FlightPath alone = PlanPath(start, views, MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(shared.length_m, alone.length_m);
  const auto may_hover = FlyablePositions(space, options);
  EXPECT_TRUE(may_hover({-8, 0, 5}));
  EXPECT_FALSE(may_hover({-6, 0, 5}));
}

}  // namespace
}  // namespace colmap_ext
