#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "nbv/hall_world.h"

namespace colmap_ext {
namespace {

// The paper's number of views.
NextBestViewOptions PaperOptions() {
  NextBestViewOptions options;
  options.strategy = "plane_sweep";
  options.num_views = 5;
  return options;
}

bool IsNear(const PlannedView& view, const Rigid3d& cam_from_world,
            const NextBestViewOptions& options) {
  const ViewDirection other = ViewDirectionOf(cam_from_world);
  const double limit = DegToRad(options.max_angle_to_existing_deg) + 1e-6;
  return (view.position - CameraCenter(cam_from_world)).norm() <=
             options.max_distance_to_existing_m + 1e-9 &&
         std::abs(NormalizeAngle(view.direction.yaw_rad - other.yaw_rad)) <= limit &&
         std::abs(view.direction.pitch_rad - other.pitch_rad) <= limit;
}

TEST(PlaneSweep, LooksAtTheUncoveredPatch) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 7), Eigen::Vector3d(3, -4, 11)});  // south wall
  const NextBestViewOptions options = PaperOptions();
  const std::vector<PosedPhoto> existing = SouthLine();
  const ViewPlanResult plan = Plan(world.map, world.mesh, existing, kCamera, 100, options, {});
  EXPECT_EQ(plan.uncovered, 24u);
  EXPECT_EQ(plan.reachable_uncovered, 24u);
  EXPECT_EQ(plan.stop_reason, "");
  EXPECT_FALSE(plan.is_bridge);
  ASSERT_GE(plan.views.size(), 1u);
  ASSERT_LE(plan.views.size(), 5u);
  int seen_by_first = 0;
  for (const IsoPoint& point : world.map.points) {
    if (point.coverage != CoverageClass::kUncovered) continue;
    seen_by_first += Sees(PoseOf(plan.views[0]), point) ? 1 : 0;
  }
  EXPECT_GE(seen_by_first, 20);
  for (std::size_t i = 0; i < plan.views.size(); ++i) {
    const PlannedView& view = plan.views[i];
    EXPECT_EQ(view.id, 100 + static_cast<int>(i));
    EXPECT_LT(view.position.y(), -9.9);
    EXPECT_GT(DirectionInWorld(view.direction).y(), 0.5);  // faces the wall
    EXPECT_GE(DistanceToHall(view.position), options.safe_distance_m);
    EXPECT_TRUE(std::any_of(existing.begin(), existing.end(), [&](const PosedPhoto& photo) {
      return IsNear(view, photo.cam_from_world, options);
    }));
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((view.position - plan.views[j].position).norm(), options.nms_radius_m);
    }
  }
}

TEST(PlaneSweep, ScoresAreSumsOfProjectionRatios) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-12, -6, 0), Eigen::Vector3d(12, -4, 11)});
  const ViewPlanResult plan =
      Plan(world.map, world.mesh, SouthLine(), kCamera, 0, PaperOptions(), {});
  ASSERT_EQ(plan.views.size(), 5u);
  for (const PlannedView& view : plan.views) {
    double sum = 0;
    for (const IsoPoint& point : world.map.points) {
      if (point.coverage != CoverageClass::kUncovered) continue;
      const Rigid3d pose = PoseOf(view);
      if (Sees(pose, point) && Ratio(pose, point) >= 625) sum += Ratio(pose, point);
    }
    EXPECT_NEAR(view.score, sum, 1e-6 * sum);
    EXPECT_GT(sum, 0);
  }
}

TEST(PlaneSweep, FliesWhereTheHighestPointIsCentredAtTheSafeDistance) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 4), Eigen::Vector3d(3, -4, 11)});  // highest: 10.5 m
  NextBestViewOptions options = PaperOptions();
  options.num_pitches = 1;
  options.min_pitch_deg = options.max_pitch_deg = -20;
  const ViewPlanResult plan = Plan(world.map, world.mesh, SouthLine(13.5), kCamera, 0, options, {});
  ASSERT_FALSE(plan.views.empty());
  EXPECT_NEAR(RadToDeg(plan.pitch_rad), -20, 1e-9);
  EXPECT_NEAR(plan.altitude_m, 10.5 + 5 * std::sin(DegToRad(20)), 1e-9);
  EXPECT_NEAR(plan.views[0].position.z(), plan.altitude_m, 1e-12);
}

TEST(PlaneSweep, SaysCoveredWhenAllIsCovered) {
  HallWorld world;
  world.map.points[0].coverage = CoverageClass::kIgnored;
  const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, {}, {});
  EXPECT_EQ(plan.stop_reason, "covered");
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.uncovered, 0u);
  EXPECT_EQ(Plan(CoverageMap{}, world.mesh, Ring(), kCamera, 0, {}, {}).stop_reason, "covered");
}

TEST(PlaneSweep, SaysWhenNothingCanBeReached) {
  HallWorld world;
  for (double x = -10; x <= 10; x += 1) world.AddPoint({x, 0, 3}, {0, 0, 1});  // inside the hall
  world.Uncover({Eigen::Vector3d(-11, -1, 2), Eigen::Vector3d(11, 1, 4)});
  const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, {}, {});
  EXPECT_EQ(plan.uncovered, 21u);
  EXPECT_EQ(plan.reachable_uncovered, 0u);
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.stop_reason, "nothing_reachable");
}

TEST(PlaneSweep, IsNotHeldUpByAHighPointThatNobodyCanSee) {
  HallWorld world;
  world.AddPoint({0, 0, 11.9}, {0, 0, -1});  // under the roof
  world.Uncover({Eigen::Vector3d(-3, -1, 11.5), Eigen::Vector3d(3, 1, 11.95)});
  world.Uncover({Eigen::Vector3d(-3, -6, 6), Eigen::Vector3d(3, -4, 9)});
  const ViewPlanResult plan = Plan(world.map, world.mesh, SouthLine(), kCamera, 0, {}, {});
  EXPECT_EQ(plan.uncovered, 19u);
  EXPECT_EQ(plan.reachable_uncovered, 18u);
  ASSERT_FALSE(plan.views.empty());
  EXPECT_GT(plan.views[0].score, 0);
}

TEST(PlaneSweep, DoesNotRepeatTheOnlyGoodView) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-1, -6, 9), Eigen::Vector3d(1, -4, 11)});
  // One photo sees the patch well.
  const std::vector<PosedPhoto> existing = {PhotoAt({0, -12, 13}, 0, -24.6)};
  const ViewPlanResult plan = Plan(world.map, world.mesh, existing, kCamera, 0, {}, {});
  ASSERT_FALSE(plan.views.empty());
  for (const IsoPoint& point : world.map.points) {
    if (point.coverage != CoverageClass::kUncovered) continue;
    const Eigen::Vector3d first = Eigen::Vector3d(0, -12, 13) - point.position;
    const Eigen::Vector3d second = plan.views[0].position - point.position;
    const double angle = std::acos(first.normalized().dot(second.normalized()));
    EXPECT_GT(RadToDeg(angle), 2);
    EXPECT_LT(RadToDeg(angle), 30);
  }
}

TEST(PlaneSweep, ChoosesPartnersForPointsThatNoPhotoSawWell) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-1, -6, 1), Eigen::Vector3d(1, -4, 3)});
  const ViewPlanResult plan = Plan(world.map, world.mesh, SouthLine(9, -15), kCamera, 0, {}, {});
  ASSERT_GE(plan.views.size(), 2u);
  for (const IsoPoint& point : world.map.points) {
    if (point.coverage != CoverageClass::kUncovered) continue;
    EXPECT_TRUE(Sees(PoseOf(plan.views[0]), point) && Sees(PoseOf(plan.views[1]), point));
  }
}

TEST(PlaneSweep, BridgesToWhatIsOutOfReach) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-2, 4, 6), Eigen::Vector3d(2, 6, 10)});  // north wall
  // The only photos are high above the south: 15 m away, and looking the other way.
  const std::vector<PosedPhoto> existing = {PhotoAt({0, -12, 20}, 0, -30)};
  NextBestViewOptions options = PaperOptions();
  options.bridge = false;
  EXPECT_EQ(Plan(world.map, world.mesh, existing, kCamera, 0, options, {}).stop_reason,
            "nothing_reachable");
  options.bridge = true;
  const ViewPlanResult plan = Plan(world.map, world.mesh, existing, kCamera, 0, options, {});
  EXPECT_TRUE(plan.is_bridge);
  EXPECT_EQ(plan.stop_reason, "");
  ASSERT_EQ(plan.views.size(), 5u);
  Rigid3d before = existing[0].cam_from_world;
  for (const PlannedView& view : plan.views) {
    EXPECT_TRUE(IsNear(view, before, options)) << view.id;
    EXPECT_GE(DistanceToHall(view.position), options.safe_distance_m);
    before = PoseOf(view);
  }
}

TEST(PlaneSweep, ChainsViewsOnlyWhenAsked) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-13, -6, 5), Eigen::Vector3d(13, -4, 12)});
  const std::vector<PosedPhoto> existing = {PhotoAt({0, -13, 15}, 0, -30)};
  NextBestViewOptions options = PaperOptions();
  options.num_views = 8;
  options.several_planes = false;
  const auto furthest = [&](const ViewPlanResult& plan) {
    double distance = 0;
    for (const PlannedView& view : plan.views) {
      distance = std::max(distance, (view.position - Eigen::Vector3d(0, -13, 15)).norm());
    }
    return distance;
  };
  EXPECT_LE(furthest(Plan(world.map, world.mesh, existing, kCamera, 0, options, {})), 3);
  options.chain_views = true;
  const ViewPlanResult chained = Plan(world.map, world.mesh, existing, kCamera, 0, options, {});
  EXPECT_GT(furthest(chained), 3);
  std::vector<Rigid3d> known = {existing[0].cam_from_world};
  for (const PlannedView& view : chained.views) {
    EXPECT_TRUE(std::any_of(known.begin(), known.end(),
                            [&](const Rigid3d& pose) { return IsNear(view, pose, options); }));
    known.push_back(PoseOf(view));
  }
}

TEST(PlaneSweep, SeesNothingThroughAScreen) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 4), Eigen::Vector3d(3, -4, 8)});
  // A screen 1 m before the south wall, higher and wider than it.
  world.AddQuad({-16, -6, 0}, {32, 0, 0}, {0, 0, 16});
  world.AddQuad({-16, -6, 16}, {32, 0, 0}, {0, 1, -0.5});  // and closed at the top
  world.AddQuad({-16, -6, 0}, {0, 1, 0}, {0, 0, 16});
  world.AddQuad({16, -6, 0}, {0, 1, 0}, {0, 0, 16});
  const ViewPlanResult plan = Plan(world.map, world.mesh, SouthLine(), kCamera, 0, {}, {});
  EXPECT_EQ(plan.reachable_uncovered, 0u);
  EXPECT_EQ(plan.stop_reason, "nothing_reachable");
}

TEST(PlaneSweep, IsTheSameWithOneThreadAndMany) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-13, -6, 0), Eigen::Vector3d(13, 6, 11)});
  const ViewPlanResult many = Plan(world.map, world.mesh, Ring(), kCamera, 0, {}, {});
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const ViewPlanResult one = Plan(world.map, world.mesh, Ring(), kCamera, 0, {}, {});
  ASSERT_EQ(one.views.size(), many.views.size());
  EXPECT_EQ(one.reachable_uncovered, many.reachable_uncovered);
  for (std::size_t i = 0; i < one.views.size(); ++i) {
    EXPECT_EQ(one.views[i].position, many.views[i].position);
    EXPECT_EQ(one.views[i].direction.yaw_rad, many.views[i].direction.yaw_rad);
    EXPECT_EQ(one.views[i].score, many.views[i].score);
  }
}

TEST(PlaneSweep, ClosesTheLoopUntilAllIsCovered) {
  HallWorld world;
  std::vector<PosedPhoto> photos = Ring();
  Evaluate(photos, &world.map);
  const double first_ratio = world.map.CoveredRatio();
  EXPECT_LT(first_ratio, 0.8);
  ViewPlanResult plan;
  int iteration = 0;
  for (; iteration < 40; ++iteration) {
    const double before = world.map.CoveredRatio();
    plan = Plan(world.map, world.mesh, photos, kCamera, 0, {}, {});
    if (plan.views.empty()) break;
    for (const PlannedView& view : plan.views) {
      PosedPhoto photo;
      photo.camera = kCamera;
      photo.cam_from_world = PoseOf(view);
      photos.push_back(photo);
    }
    Evaluate(photos, &world.map);
    EXPECT_GE(world.map.CoveredRatio(), before);
  }
  RecordProperty("iterations", iteration);
  RecordProperty("photos", static_cast<int>(photos.size()));
  EXPECT_NE(plan.stop_reason, "");
  EXPECT_EQ(plan.reachable_uncovered, 0u);
  EXPECT_GT(world.map.CoveredRatio(), 0.97);
  EXPECT_LT(iteration, 30);
}

TEST(PlaneSweep, RefusesBadOptionsAndNoPhotos) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 4), Eigen::Vector3d(3, -4, 8)});
  EXPECT_THROW(Plan(world.map, world.mesh, {}, kCamera, 0, {}, {}), Error);
  NextBestViewOptions options = PaperOptions();
  options.num_yaws = 0;
  EXPECT_THROW(Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {}), UsageError);
  options = {};
  options.min_pitch_deg = 40;
  EXPECT_THROW(Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {}), UsageError);
  options = {};
  options.safe_distance_m = -1;
  EXPECT_THROW(Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {}), UsageError);
}

TEST(PlaneSweep, StopsWhenCancelled) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 4), Eigen::Vector3d(3, -4, 8)});
  const std::atomic<bool> cancel{true};
  EXPECT_THROW(Plan(world.map, world.mesh, Ring(), kCamera, 0, {}, JobControl(nullptr, &cancel)),
               CancelledError);
}

TEST(PlaneSweep, PaperOnlyIsThePapersSearch) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-3, -6, 4), Eigen::Vector3d(3, -4, 11)});  // highest: 10.5 m
  world.AddPoint({0, 0, 11.9}, {0, 0, -1});  // under the roof: nobody can see it, yet it counts
  world.map.points.back().coverage = CoverageClass::kUncovered;
  NextBestViewOptions options = PaperOptions();
  options.paper_only = true;
  const std::vector<PosedPhoto> existing = SouthLine(13.5, -20);
  const ViewPlanResult plan = Plan(world.map, world.mesh, existing, kCamera, 0, options, {});
  ASSERT_FALSE(plan.views.empty());
  EXPECT_LE(plan.views.size(), 5u);
  EXPECT_NEAR(plan.altitude_m, 11.9 - 5 * std::sin(plan.pitch_rad), 1e-9);
  for (const PlannedView& view : plan.views) {
    EXPECT_EQ(view.position.z(), plan.altitude_m);
    EXPECT_EQ(view.direction.pitch_rad, plan.pitch_rad);
    double sum = 0;  // at any ratio
    for (const IsoPoint& point : world.map.points) {
      if (point.coverage == CoverageClass::kUncovered && Sees(PoseOf(view), point)) {
        sum += Ratio(PoseOf(view), point);
      }
    }
    EXPECT_NEAR(view.score, sum, 1e-6 * sum);
  }
  EXPECT_EQ(plan.shared_features, std::vector<double>(plan.views.size(), -1));
}

TEST(PlaneSweep, CoarseSearchLosesLittle) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = PaperOptions();
  options.coarse_step = 1;
  const ViewPlanResult full = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
  options.coarse_step = 3;
  const ViewPlanResult coarse = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
  ASSERT_FALSE(full.views.empty());
  ASSERT_FALSE(coarse.views.empty());
  EXPECT_GE(coarse.views[0].score, 0.9 * full.views[0].score);
}

TEST(NextBestViewOptions, BindsEachFieldOnce) {
  NextBestViewOptions options;
  OptionSet set;
  BindOptions(set, &options);
  set.Parse({"--NextBestView.num_views", "9", "--NextBestView.safe_distance_m", "0.5"});
  EXPECT_EQ(options.num_views, 9);
  EXPECT_EQ(options.safe_distance_m, 0.5);
  EXPECT_EQ(options.Check(), "");
}

TEST(NextBestViewOptions, ThePapersSearchIsNotAskedOfAnotherStrategy) {
  NextBestViewOptions options;
  options.paper_only = true;
  EXPECT_NE(options.Check().find("plane_sweep"), std::string::npos);
  options.strategy = "plane_sweep";
  EXPECT_EQ(options.Check(), "");
}

}  // namespace
}  // namespace colmap_ext
