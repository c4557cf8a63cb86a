#include "colmap_ext/sim/vehicle_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/sim/vehicle_parts.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Eigen::Vector3d;

VehicleMotionOptions Calm() {
  VehicleMotionOptions options;
  options.wind = {0, 0, 0};
  return options;
}

MotionTarget FlyTo(const Vector3d& position, double yaw_rad = 0) {
  MotionTarget target;
  target.motors = true;
  target.position = position;
  target.yaw_rad = yaw_rad;
  return target;
}

// Seconds until it is within 0.2 m and slower than 0.1 m/s for a second; -1: never within `most_s`.
double TimeToSettle(VehicleMotion* motion, const Vector3d& goal, double most_s) {
  double settled_s = 0;
  for (double time = 0; time < most_s; time += 0.05) {
    motion->Step(0.05);
    const MotionState& state = motion->state();
    const bool is_there = (state.position - goal).norm() < 0.2 && state.velocity.norm() < 0.1;
    settled_s = is_there ? settled_s + 0.05 : 0;
    if (settled_s >= 1) return time;
  }
  return -1;
}

TEST(VehicleMotion, KeepsItsLimitsOnRandomFlights) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-40, 40), height(3, 40), angle(-3.1, 3.1);
  const VehicleMotionOptions options = Calm();
  VehicleMotion motion(options, Vector3d::Zero(), 0, 1);
  for (int flight = 0; flight < 60; ++flight) {
    // Targets change while it still moves.
    motion.SetTarget(FlyTo({place(random), place(random), height(random)}, angle(random)));
    for (int i = 0; i < 400; ++i) {
      motion.Step(0.01);
      const MotionState& state = motion.state();
      ASSERT_LE(state.velocity.head<2>().norm(), 1.05 * options.max_speed_m_s);
      ASSERT_LE(state.velocity.z(), 1.1 * options.max_climb_m_s);
      ASSERT_GE(state.velocity.z(), -1.1 * options.max_descent_m_s - 0.1);
      ASSERT_LE(state.acceleration.head<2>().norm(), 1.2 * options.max_acceleration_m_s2);
      ASSERT_LE(std::abs(state.acceleration.z()), 1.2 * options.max_acceleration_m_s2);
      ASSERT_LE(std::abs(state.yaw_rate_rad_s), DegToRad(options.max_yaw_rate_deg_s) + 1e-12);
      ASSERT_LT(std::abs(state.pitch_rad), DegToRad(30));
    }
  }
}

TEST(VehicleMotion, ReachesTargetsStraightAndWithoutOvershoot) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-30, 30), height(5, 30);
  VehicleMotion motion(Calm(), Vector3d::Zero(), 0, 1);
  Vector3d from(0, 0, 10);
  motion.SetTarget(FlyTo(from));
  ASSERT_GE(TimeToSettle(&motion, from, 30), 0);
  for (int flight = 0; flight < 20; ++flight) {
    const Vector3d goal(place(random), place(random), height(random));
    const Vector3d along = (goal - from).normalized();
    motion.SetTarget(FlyTo(goal));
    for (int i = 0; i < 400; ++i) {
      motion.Step(0.1);
      const Vector3d offset = motion.state().position - from;
      ASSERT_LT((offset - along * along.dot(offset)).norm(), 0.7) << "off the line";
      ASSERT_LT(along.dot(offset), (goal - from).norm() + 0.3) << "too far";
    }
    ASSERT_LT((motion.state().position - goal).norm(), 0.05);
    from = motion.state().position;
  }
}

TEST(VehicleMotion, HoldsItsPlaceInWind) {
  VehicleMotionOptions options;
  options.wind = {8, 270, 1};
  VehicleMotion motion(options, Vector3d::Zero(), 0, 4);
  const Vector3d goal(10, -5, 12);
  motion.SetTarget(FlyTo(goal));
  motion.Step(40);
  double largest = 0, tilt = 0;
  for (int i = 0; i < 600; ++i) {
    motion.Step(0.1);
    largest = std::max(largest, (motion.state().position - goal).norm());
    tilt += motion.state().roll_rad / 600;
  }
  EXPECT_LT(largest, 0.6);
  EXPECT_GT(largest, 0.005) << "gusts must be felt";
  EXPECT_LT(tilt, DegToRad(-3)) << "wind from the west: with the nose north it leans to its left";
}

TEST(VehicleMotion, AnErrorOfTheEstimateMovesIt) {
  VehicleMotion motion(Calm(), Vector3d::Zero(), 0, 1);
  const Vector3d goal(5, 5, 10), error(0.7, -0.4, 0.3);
  motion.SetTarget(FlyTo(goal));
  motion.Step(30, error);
  EXPECT_LT((motion.state().position - (goal - error)).norm(), 0.02);
}

TEST(VehicleMotion, TheSameHoweverTimeIsCut) {
  const auto fly = [](double step_s, int steps, std::uint64_t seed) {
    VehicleMotionOptions options;
    options.wind = {5, 30, 2};
    VehicleMotion motion(options, Vector3d::Zero(), 1, seed);
    motion.SetTarget(FlyTo({20, 3, 9}, -2));
    for (int i = 0; i < steps; ++i) motion.Step(step_s);
    return motion.state();
  };
  const MotionState whole = fly(12, 1, 7), cut = fly(0.004, 3000, 7), other = fly(12, 1, 8);
  EXPECT_EQ(whole.position, cut.position);
  EXPECT_EQ(whole.velocity, cut.velocity);
  EXPECT_EQ(whole.yaw_rad, cut.yaw_rad);
  EXPECT_NE(whole.position, other.position);
}

TEST(VehicleMotion, TurnsTheShortWay) {
  VehicleMotion motion(Calm(), Vector3d::Zero(), DegToRad(170), 1);
  motion.SetTarget(FlyTo({0, 0, 5}, DegToRad(-170)));
  double turned = 0;
  for (int i = 0; i < 1000; ++i) {
    motion.Step(0.01);
    turned += motion.state().yaw_rate_rad_s * 0.01;
  }
  EXPECT_NEAR(RadToDeg(turned), 20, 0.5);
  EXPECT_NEAR(motion.state().yaw_rad, DegToRad(-170), 0.01);
}

TEST(VehicleMotion, LandsOnWhatIsBelow) {
  const auto roof = [](const Vector3d& p) { return p.x() > 5 ? 4.0 : 0.0; };
  VehicleMotion motion(Calm(), Vector3d::Zero(), 0, 1, roof);
  EXPECT_TRUE(motion.state().on_ground);
  motion.SetTarget(FlyTo({10, 0, 9}));
  motion.Step(20);
  EXPECT_FALSE(motion.state().on_ground);
  MotionTarget land = FlyTo({10, 0, 0});
  land.climb_rate_m_s = -0.7;
  motion.SetTarget(land);
  motion.Step(15);
  EXPECT_TRUE(motion.state().on_ground);
  EXPECT_EQ(motion.state().position.z(), 4.0);
  EXPECT_LT(motion.state().impact_speed_m_s, 1.0);
  const Vector3d stands = motion.state().position;
  motion.Step(10);
  EXPECT_EQ(motion.state().position, stands) << "wind does not move what stands";
}

TEST(VehicleMotion, FallsWithoutMotors) {
  VehicleMotion motion(Calm(), Vector3d::Zero(), 0, 1);
  motion.SetTarget(FlyTo({0, 0, 20}));
  motion.Step(20);
  motion.SetTarget({});
  motion.Step(5);
  EXPECT_TRUE(motion.state().on_ground);
  EXPECT_NEAR(motion.state().impact_speed_m_s, std::sqrt(2 * 9.81 * 20), 0.5);
}

TEST(VehicleMotion, BadOptionsAreNamed) {
  const auto complaint = [](auto change) {
    VehicleMotionOptions options;
    change(options);
    return options.Check();
  };
  EXPECT_EQ(VehicleMotionOptions().Check(), "");
  EXPECT_NE(complaint([](auto& o) { o.max_speed_m_s = 0; }).find("max_speed_m_s"),
            std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.max_climb_m_s = NAN; }).find("max_climb"), std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.wind.gust_m_s = -1; }).find("gust_m_s"), std::string::npos);
  VehicleMotionOptions bad;
  bad.max_yaw_rate_deg_s = -3;
  EXPECT_THROW(VehicleMotion(bad, Vector3d::Zero(), 0, 1), UsageError);
}

TEST(SimulatedGps, WandersWithItsSigma) {
  GpsOptions options;
  options.gps_bias_m = 0.5;
  options.gps_bias_time_s = 20;
  options.gps_noise_m = 0.3;
  SimulatedGps gps(options, 2);
  double bias = 0, noise = 0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    gps.Step(1);
    if (i < 60) continue;  // the first fix, and the drift before it
    bias += gps.EstimateError().x() * gps.EstimateError().x() / kSamples;
    noise += std::pow(gps.FixError().y() - gps.EstimateError().y(), 2) / kSamples;
  }
  EXPECT_NEAR(std::sqrt(bias), 0.5, 0.1);
  EXPECT_NEAR(std::sqrt(noise), std::hypot(0.3, 0.1), 0.05);
}

TEST(SimulatedGps, AGlitchIsRejectedThenFollowed) {
  GpsOptions options;
  options.gps_bias_m = options.gps_noise_m = 0;
  SimulatedGps gps(options, 1);
  EXPECT_FALSE(gps.HasFix());
  gps.Step(60);
  EXPECT_TRUE(gps.HasFix());
  const double before = gps.EstimateError().norm();
  gps.SetGlitch({15, 0, 0});
  gps.Step(3);
  EXPECT_TRUE(gps.IsGlitching());
  EXPECT_GT(gps.HorizontalAccuracy(), 2);
  EXPECT_NEAR(gps.FixError().x(), 15, 1e-9);
  EXPECT_NEAR(gps.EstimateError().norm(), before, 0.01);
  gps.Step(15);
  EXPECT_FALSE(gps.IsGlitching());
  EXPECT_NEAR(gps.EstimateError().x(), 15, 0.5);
  gps.SetLost(true);
  EXPECT_FALSE(gps.HasFix());
  const double lost_at = gps.EstimateError().x();
  gps.Step(10);
  EXPECT_NEAR(gps.EstimateError().x(), lost_at + 1, 0.1) << "it drifts";
}

TEST(SimulatedBattery, LastsAsLongAsItsEnergy) {
  BatteryOptions options;
  options.battery_wh = 10;
  options.hover_power_w = 100;
  options.idle_power_w = 0;
  SimulatedBattery battery(options);
  MotionState hover;
  hover.on_ground = false;
  const double full_v = battery.voltage();
  for (int i = 0; i < 180; ++i) battery.Step(1, hover, true);
  EXPECT_NEAR(battery.percent(), 50, 1e-9);
  EXPECT_NEAR(battery.consumed_wh(), 5, 1e-9);
  EXPECT_NEAR(battery.TimeLeft(), 180, 1e-6);
  EXPECT_LT(battery.voltage(), full_v - 0.5);
  MotionState climb = hover;
  climb.velocity.z() = 2;
  battery.Step(1, climb, true);
  EXPECT_GT(battery.power_w(), 140);
  for (int i = 0; i < 500; ++i) battery.Step(1, hover, true);
  EXPECT_EQ(battery.percent(), 0);
  battery.SetPercent(130);
  EXPECT_EQ(battery.percent(), 100);
}

TEST(SimulatedGimbal, MovesAtItsRateWithinItsRange) {
  GimbalOptions options;
  options.gimbal_jitter_deg = 0;
  options.gimbal_rate_deg_s = 30;
  SimulatedGimbal gimbal(options, 1);
  gimbal.SetTarget(DegToRad(-60), 0, false);
  gimbal.Step(1, 0);
  EXPECT_NEAR(RadToDeg(gimbal.pitch_rad()), -30, 1e-9);
  gimbal.Step(5, 0);
  EXPECT_NEAR(RadToDeg(gimbal.pitch_rad()), -60, 1e-9);
  gimbal.SetTarget(DegToRad(-170), 0, false);
  gimbal.Step(10, 0);
  EXPECT_NEAR(RadToDeg(gimbal.pitch_rad()), -95, 1e-9);
}

TEST(SimulatedGimbal, FollowsTheNoseOrKeepsAHeading) {
  GimbalOptions options;
  options.gimbal_jitter_deg = 0;
  SimulatedGimbal gimbal(options, 1);
  gimbal.SetTarget(0, DegToRad(20), false);
  gimbal.Step(5, DegToRad(100));
  EXPECT_NEAR(RadToDeg(gimbal.Heading(DegToRad(100))), 120, 1e-9);
  gimbal.SetTarget(0, DegToRad(90), true);
  gimbal.Step(5, DegToRad(60));
  EXPECT_NEAR(RadToDeg(gimbal.Heading(DegToRad(60))), 90, 1e-9);
  gimbal.SetStuck(true);
  gimbal.SetTarget(DegToRad(-90), 0, false);
  gimbal.Step(5, 0);
  EXPECT_EQ(gimbal.pitch_rad(), 0);
}

TEST(VehicleParts, BadOptionsAreNamed) {
  GpsOptions gps;
  gps.gps_bias_time_s = 0;
  EXPECT_NE(gps.Check().find("gps_bias_time_s"), std::string::npos);
  BatteryOptions battery;
  battery.battery_percent = 101;
  EXPECT_NE(battery.Check().find("battery_percent"), std::string::npos);
  GimbalOptions gimbal;
  gimbal.min_pitch_deg = 40;
  EXPECT_NE(gimbal.Check().find("gimbal_min_pitch_deg"), std::string::npos);
  EXPECT_THROW(SimulatedGimbal(gimbal, 1), UsageError);
}

}  // namespace
}  // namespace colmap_ext
