// What every strategy respects, and what it says of hopeless input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "nbv/hall_world.h"

namespace colmap_ext {
namespace {

class EveryStrategy : public ::testing::TestWithParam<const char*> {
 protected:
  EveryStrategy() {
    Evaluate(Ring(), &world_.map);
    options_.strategy = GetParam();
    options_.num_positions = 400;
  }

  ViewPlanResult PlanWith(const FlightLimits& limits,
                          const std::function<bool(const Eigen::Vector3d&)>& may_fly = nullptr) {
    ViewPlanInput input{world_.map, world_.mesh, photos_};
    input.camera = kCamera;
    input.limits = &limits;
    input.limits_margin_m = 0.5;
    input.may_fly = may_fly;
    return PlanNextViews(input, options_, {});
  }

  HallWorld world_;
  std::vector<PosedPhoto> photos_ = Ring();
  NextBestViewOptions options_;
};

FlightZone Box(FlightZone::Kind kind, double min_x, double min_y, double max_x, double max_y) {
  FlightZone zone;
  zone.kind = kind;
  zone.rings = {{{min_x, min_y}, {max_x, min_y}, {max_x, max_y}, {min_x, max_y}}};
  return zone;
}

TEST_P(EveryStrategy, KeepsDistancesAltitudesAndGimbal) {
  options_.safe_distance_m = 7;
  options_.max_distance_m = 14;
  options_.min_altitude_m = 6;
  options_.max_altitude_m = 17;
  options_.min_gimbal_pitch_deg = -35;
  options_.max_gimbal_pitch_deg = -10;
  const ViewPlanResult plan = PlanWith({});
  ASSERT_FALSE(plan.views.empty());
  for (const PlannedView& view : plan.views) {
    EXPECT_GE(DistanceToHall(view.position), 7);
    EXPECT_LE(DistanceToHall(view.position), 14);
    EXPECT_GE(view.position.z(), 6.5);
    EXPECT_LE(view.position.z(), 17);
    EXPECT_GE(RadToDeg(view.direction.pitch_rad), -35 - 1e-9);
    EXPECT_LE(RadToDeg(view.direction.pitch_rad), -10 + 1e-9);
  }
}

TEST_P(EveryStrategy, StaysInTheFenceAndOutOfNoFlyZones) {
  FlightLimits limits;
  limits.zones.push_back(Box(FlightZone::Kind::kInclusion, -40, -40, 40, 0));
  limits.zones.push_back(Box(FlightZone::Kind::kExclusion, -6, -40, 6, 0));
  const ViewPlanResult plan = PlanWith(limits);
  ASSERT_FALSE(plan.views.empty());
  for (const PlannedView& view : plan.views) {
    EXPECT_LE(view.position.y(), -0.5);
    EXPECT_GE(std::abs(view.position.x()), 6.5);
  }
}

TEST_P(EveryStrategy, GoesOnlyWhereItMayFly) {
  const ViewPlanResult plan =
      PlanWith({}, [](const Eigen::Vector3d& p) { return p.x() > 0 && p.z() > 8; });
  ASSERT_FALSE(plan.views.empty());
  for (const PlannedView& view : plan.views) {
    EXPECT_GT(view.position.x(), 0);
    EXPECT_GT(view.position.z(), 8);
  }
}

TEST_P(EveryStrategy, SaysThatAFenceExcludesEverything) {
  FlightLimits limits;
  limits.zones.push_back(Box(FlightZone::Kind::kInclusion, 1000, 1000, 1010, 1010));
  const ViewPlanResult plan = PlanWith(limits);
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.stop_reason, "nothing_reachable");
  EXPECT_NE(plan.explanation.find("outside the geofence"), std::string::npos) << plan.explanation;
  EXPECT_EQ(plan.reachable_uncovered, 0u);
}

TEST_P(EveryStrategy, SaysCoveredWhenNothingIsWanted) {
  for (IsoPoint& point : world_.map.points) point.coverage = CoverageClass::kCovered;
  EXPECT_EQ(PlanWith({}).stop_reason, "covered");
  for (IsoPoint& point : world_.map.points) point.coverage = CoverageClass::kIgnored;
  EXPECT_EQ(PlanWith({}).stop_reason, "covered");
  world_.map.points.clear();  // an empty region
  EXPECT_EQ(PlanWith({}).stop_reason, "covered");
}

TEST_P(EveryStrategy, SaysWhyNothingCanBeReached) {
  for (IsoPoint& point : world_.map.points) {
    point.coverage = CoverageClass::kUncovered;
    point.normal = -point.normal;  // only the inside
  }
  const ViewPlanResult plan = PlanWith({});
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.stop_reason, "nothing_reachable");
  EXPECT_NE(plan.explanation.find("hidden"), std::string::npos) << plan.explanation;
}

TEST_P(EveryStrategy, StartsFromOnePhoto) {
  photos_ = {PhotoAt({0, -14, 13}, 0, -25)};
  Evaluate(photos_, &world_.map);
  const ViewPlanResult plan = PlanWith({});
  EXPECT_FALSE(plan.views.empty());
  for (const PlannedView& view : plan.views) EXPECT_GE(DistanceToHall(view.position), 5);
}

TEST_P(EveryStrategy, PlansOneView) {
  options_.num_views = 1;
  EXPECT_EQ(PlanWith({}).views.size(), 1u);
}

TEST_P(EveryStrategy, HasNoPitchToTryWhenTheGimbalIsFixedElsewhere) {
  options_.min_gimbal_pitch_deg = options_.max_gimbal_pitch_deg = 80;
  const ViewPlanResult plan = PlanWith({});
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.stop_reason, "nothing_reachable");
  EXPECT_FALSE(plan.explanation.empty());
}

TEST_P(EveryStrategy, RefusesBadOptions) {
  const auto is_refused = [&](const std::function<void(NextBestViewOptions*)>& spoil) {
    NextBestViewOptions bad = options_;
    spoil(&bad);
    EXPECT_NE(bad.Check(), "");
    EXPECT_THROW(Plan(world_.map, world_.mesh, photos_, kCamera, 0, bad, {}), UsageError);
  };
  is_refused([](NextBestViewOptions* o) { o->strategy = "best"; });
  is_refused([](NextBestViewOptions* o) { o->max_distance_m = 1; });
  is_refused([](NextBestViewOptions* o) { o->min_gimbal_pitch_deg = 40; });
  is_refused([](NextBestViewOptions* o) { o->num_positions = 0; });
  is_refused([](NextBestViewOptions* o) { o->max_tour_length_m = -1; });
  is_refused([](NextBestViewOptions* o) { o->sun_weight = 2; });
  is_refused([](NextBestViewOptions* o) { o->max_feature_scale = 1; });
}

INSTANTIATE_TEST_SUITE_P(All, EveryStrategy,
                         ::testing::Values("plane_sweep", "submodular", "random",
                                           "next_farthest_point", "hemisphere", "smith2018"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace colmap_ext
