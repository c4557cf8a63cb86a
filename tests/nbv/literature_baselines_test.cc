#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nbv/hall_world.h"
#include "nbv/reconstructability.h"

namespace colmap_ext {
namespace {

using PointView = Reconstructability::PointView;

PointView ViewAtAngle(double angle_deg, double distance_m, double cos_incidence = 1) {
  const double angle = DegToRad(angle_deg);
  return {{std::cos(angle), std::sin(angle), 0}, distance_m, cos_incidence};
}

double OfAngle(double angle_deg) {
  return Reconstructability::OfPair(ViewAtAngle(0, 5), ViewAtAngle(angle_deg, 5), 20);
}

TEST(Reconstructability, LikesPairsWithParallaxThatCanStillBeMatched) {
  EXPECT_LT(OfAngle(1), 0.01);
  EXPECT_GT(OfAngle(22), 5 * OfAngle(5));
  EXPECT_GT(OfAngle(22), OfAngle(45));
  EXPECT_GT(OfAngle(45), 2 * OfAngle(80));
  // The equation by hand, at 22.5 degrees from 5 of 20 m: w1 = 1/(1+e^-2π), w3 = 1 - 1/(1+e^π).
  const double by_hand = 1 / (1 + std::exp(-2 * M_PI)) * 0.75 * (1 - 1 / (1 + std::exp(M_PI)));
  EXPECT_NEAR(OfAngle(22.5), by_hand, 1e-12);
}

TEST(Reconstructability, LikesNearAndFrontalPairs) {
  const PointView first = ViewAtAngle(0, 5);
  const double best = Reconstructability::OfPair(first, ViewAtAngle(20, 5), 20);
  EXPECT_LT(Reconstructability::OfPair(first, ViewAtAngle(20, 15), 20), best);
  EXPECT_LT(Reconstructability::OfPair(first, ViewAtAngle(20, 5, 0.4), 20), best);
  EXPECT_EQ(Reconstructability::OfPair(first, ViewAtAngle(20, 25), 20), 0);
}

NextBestViewOptions OptionsOf(const std::string& strategy) {
  NextBestViewOptions options;
  options.strategy = strategy;
  options.num_positions = 200;
  options.num_views = 8;
  return options;
}

ViewPlanResult PlanHall(const HallWorld& world, const NextBestViewOptions& options,
                        const std::function<bool(const Eigen::Vector3d&)>& may_reach = nullptr) {
  const std::vector<PosedPhoto> photos = Ring();
  ViewPlanInput input{world.map, world.mesh, photos};
  input.camera = kCamera;
  input.may_reach = may_reach;
  return PlanNextViews(input, options, {});
}

std::size_t CoveredWith(const ViewPlanResult& plan, HallWorld* world) {
  std::vector<PosedPhoto> photos = Ring();
  for (const PlannedView& view : plan.views) {
    photos.push_back(photos.front());
    photos.back().cam_from_world = PoseOf(view);
  }
  Evaluate(photos, &world->map);
  return world->map.Count(CoverageClass::kCovered);
}

TEST(Hemisphere, LooksAtTheMiddleFromAllSidesAtOneDistance) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = OptionsOf("hemisphere");
  options.min_shared_features = 0;
  const ViewPlanResult plan = PlanHall(world, options);
  ASSERT_EQ(plan.views.size(), 8u);
  const Eigen::Vector3d middle(0, 0, 0.5);  // of the lowest points
  const double radius = (plan.views.front().position - middle).norm();
  int north = 0;
  for (const PlannedView& view : plan.views) {
    EXPECT_NEAR((view.position - middle).norm(), radius, 1e-9);
    const Eigen::Vector3d towards = (middle - view.position).normalized();
    EXPECT_GT(DirectionInWorld(view.direction).dot(towards), 1 - 1e-9);
    north += view.position.y() > 0 ? 1 : 0;
  }
  EXPECT_GT(north, 1);
  EXPECT_LT(north, 7);
}

TEST(Smith2018, PlansRegistrableViewsThatCover) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  const std::size_t before = world.map.Count(CoverageClass::kCovered);
  const NextBestViewOptions options = OptionsOf("smith2018");
  const ViewPlanResult plan = PlanHall(world, options);
  ASSERT_GE(plan.views.size(), 4u);
  for (const double shared : plan.shared_features) EXPECT_GE(shared, options.min_shared_features);
  for (const PlannedView& view : plan.views) {
    EXPECT_GE(DistanceToHall(view.position), options.safe_distance_m);
  }
  EXPECT_GT(CoveredWith(plan, &world), before + 30);
}

// Where one photo sees a wall from 10 m, the next view of it is chosen for the angle that it adds.
TEST(PredictedErrorObjective, AddsTheViewThatMakesAnExactPair) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -5.1, 3), Eigen::Vector3d(3, -4.9, 9)});
  const std::vector<PosedPhoto> photos = {PhotoAt({0, -15, 6}, 0, 0)};
  ViewPlanInput input{world.map, world.mesh, photos};
  input.camera = kCamera;
  NextBestViewOptions options = OptionsOf("submodular");
  options.min_shared_features = 0;
  options.num_views = 1;
  const Eigen::Vector3d wall(0, -5, 6);
  const auto angle_deg = [&](const std::string& objective) {
    options.objective = objective;
    const ViewPlanResult plan = PlanNextViews(input, options, {});
    if (plan.views.size() != 1) return -1.0;
    const Eigen::Vector3d first = Eigen::Vector3d(0, -15, 6) - wall;
    const Eigen::Vector3d second = plan.views[0].position - wall;
    return RadToDeg(std::acos(first.normalized().dot(second.normalized())));
  };
  const double stereo = angle_deg("stereo"), accurate = angle_deg("predicted_error");
  EXPECT_GT(stereo, 0);
  EXPECT_GT(accurate, 10);  // e0 is that of 15 degrees
  EXPECT_LT(accurate, 30);
  options.objective = "beauty";
  EXPECT_NE(options.Check(), "");
}

class WithUnreachablePlaces : public ::testing::TestWithParam<const char*> {};

TEST_P(WithUnreachablePlaces, ChoosesViewsOnlyWhereAWayLeads) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  const ViewPlanResult plan =
      PlanHall(world, OptionsOf(GetParam()), [](const Eigen::Vector3d& p) { return p.x() > 0; });
  ASSERT_FALSE(plan.views.empty());
  for (const PlannedView& view : plan.views) EXPECT_GT(view.position.x(), 0);
  const ViewPlanResult none =
      PlanHall(world, OptionsOf(GetParam()), [](const Eigen::Vector3d&) { return false; });
  EXPECT_TRUE(none.views.empty());
  EXPECT_EQ(none.stop_reason, "nothing_reachable");
}

INSTANTIATE_TEST_SUITE_P(Strategies, WithUnreachablePlaces,
                         ::testing::Values("plane_sweep", "submodular", "random",
                                           "next_farthest_point", "hemisphere", "smith2018"));

}  // namespace
}  // namespace colmap_ext
