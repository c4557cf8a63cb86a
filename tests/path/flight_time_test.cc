#include "colmap_ext/path/flight_time.h"

#include <gtest/gtest.h>

#include <cmath>

#include "colmap_ext/util/error.h"
#include "path/battery.h"
#include "path/box_world.h"

namespace colmap_ext {
namespace {

PathOptions Options() {
  PathOptions options;
  options.speed_m_s = 2;
  options.climb_speed_m_s = 1;
  options.descent_speed_m_s = 0.5;
  options.acceleration_m_s2 = 2;
  options.yaw_rate_deg_s = 30;
  options.hover_s = 5;
  options.battery_s = 0;
  return options;
}

TEST(TimeBetween, SpeedsUpAndDown) {
  const PathOptions options = Options();
  EXPECT_NEAR(TimeBetween({0, 0, 0}, {10, 0, 0}, options), 10 / 2.0 + 2 / 2.0, 1e-12);
  // Too short to reach the speed: half the way at 2 m/s², the other half back.
  EXPECT_NEAR(TimeBetween({0, 0, 0}, {0.5, 0, 0}, options), 2 * std::sqrt(0.25), 1e-12);
  // Up 10 m takes longer than 10 m along; down longer still.
  EXPECT_NEAR(TimeBetween({0, 0, 0}, {10, 0, 10}, options), 10 + 0.5, 1e-12);
  EXPECT_NEAR(TimeBetween({0, 0, 10}, {10, 0, 0}, options), 20 + 0.25, 1e-12);
  EXPECT_EQ(TimeBetween({1, 2, 3}, {1, 2, 3}, options), 0);
}

TEST(EstimateDuration, AddsFlightTurnsAndHovers) {
  const std::vector<Waypoint> waypoints = {{{0, 0, 0}, {0, 0}, -1},
                                           {{10, 0, 0}, {DegToRad(90), 0}, 1},
                                           {{10, 6, 0}, {DegToRad(-150), 0}, 2}};
  EXPECT_NEAR(EstimateDuration(waypoints, Options()),
              (10 / 2.0 + 1) + (6 / 2.0 + 1) + (90 + 120) / 30.0 + 10, 1e-9);
  EXPECT_EQ(EstimateDuration({}, Options()), 0);
}

// Nodes on a line at x = node, a second a metre, home at 0.
double OnALine(int from, int to) { return std::abs(from - to); }

TEST(SplitByBattery, ReturnsBeforeTheBatteryIsEmpty) {
  const BatterySplit split = SplitByBattery({0, 1, 2, 3, 4, 5}, 0, 100, OnALine);
  EXPECT_EQ(split.flights, (std::vector<std::vector<int>>{{0, 1, 2, 3, 4, 5}}));
  // 8 s: to 4 and back. The next flight goes from home to 3, and could not to 4 by way of 5.
  const BatterySplit two = SplitByBattery({0, 1, 4, 3, 2}, 0, 8, OnALine);
  EXPECT_EQ(two.flights, (std::vector<std::vector<int>>{{0, 1, 4, 3, 2}}));
  const BatterySplit back = SplitByBattery({0, 4, 1, 4, 1}, 0, 8, OnALine);
  EXPECT_EQ(back.flights, (std::vector<std::vector<int>>{{0, 4, 1}, {0, 4, 1}}));
  EXPECT_TRUE(back.too_far.empty());
}

TEST(SplitByBattery, LeavesOutWhatNoBatteryReaches) {
  const BatterySplit split = SplitByBattery({0, 2, 9, 3}, 0, 8, OnALine);
  EXPECT_EQ(split.too_far, std::vector<int>{9});
  EXPECT_EQ(split.flights, (std::vector<std::vector<int>>{{0, 2, 3}}));
}

TEST(FlyInOrder, SplitsIntoFlightsThatStartAndEndAtHome) {
  std::vector<PlannedView> views;
  for (int i = 0; i < 12; ++i) views.push_back(ViewAt(i, 10.0 * (i % 6), i < 6 ? 0 : 10, 5));
  PathOptions options = Options();
  const FlightPath one = FlyInOrder(views, options);
  EXPECT_EQ(one.flights.size(), 1u);
  EXPECT_EQ(one.waypoints.size(), 13u);  // from home, which is the first view's place
  EXPECT_EQ(one.min_clearance_m, 0);
  options.battery_s = 200;
  options.battery_reserve = 0.25;
  options.takeoff_landing_s = 20;
  const FlightPath split = FlyInOrder(views, options);
  ASSERT_EQ(split.flights.size(), 2u);
  EXPECT_GT(split.flights[0].battery_share, 0.6);  // as much as it carries
  EXPECT_TRUE(split.dropped_view_ids.empty());
  double length = 0;
  for (std::size_t i = 0; i < split.flights.size(); ++i) {
    const BatteryFlight& flight = split.flights[i];
    EXPECT_LE(flight.battery_share, 0.75 + 1e-9);
    EXPECT_EQ(split.waypoints[flight.first_waypoint].position, views[0].position);
    if (i > 0) {
      EXPECT_EQ(flight.first_waypoint, split.flights[i - 1].last_waypoint);
    }
    length += flight.length_m;
  }
  EXPECT_NEAR(split.length_m, length, 1e-9);
  int photos = 0;
  for (const Waypoint& waypoint : split.waypoints) photos += waypoint.view_id >= 0 ? 1 : 0;
  EXPECT_EQ(photos, 12);
  EXPECT_TRUE(FlyInOrder({}, options).waypoints.empty());
}

}  // namespace
}  // namespace colmap_ext
