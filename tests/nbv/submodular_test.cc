#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "colmap_ext/util/error.h"
#include "nbv/hall_world.h"

namespace colmap_ext {
namespace {

NextBestViewOptions Submodular() {
  NextBestViewOptions options;
  options.strategy = "submodular";
  options.num_positions = 400;
  return options;
}

std::vector<PosedPhoto> WithViews(std::vector<PosedPhoto> photos, const ViewPlanResult& plan) {
  for (const PlannedView& view : plan.views) {
    PosedPhoto photo;
    photo.camera = kCamera;
    photo.cam_from_world = PoseOf(view);
    photos.push_back(photo);
  }
  return photos;
}

// Photos that a strategy takes until this part is covered.
std::size_t PhotosToCover(double ratio, NextBestViewOptions options) {
  options.num_views = 6;
  HallWorld world;
  std::vector<PosedPhoto> photos = Ring();
  const std::size_t first = photos.size();
  for (int iteration = 0; iteration < 30; ++iteration) {
    Evaluate(photos, &world.map);
    if (world.map.CoveredRatio() >= ratio) break;
    const ViewPlanResult plan = Plan(world.map, world.mesh, photos, kCamera, 0, options, {});
    if (plan.views.empty()) break;
    photos = WithViews(photos, plan);
  }
  EXPECT_GE(world.map.CoveredRatio(), ratio) << options.strategy;
  return photos.size() - first;
}

TEST(Submodular, CoversWhatItPromisesInOnePlan) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  const std::size_t before = world.map.Count(CoverageClass::kUncovered);
  NextBestViewOptions options = Submodular();
  options.num_views = 30;
  const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 7, options, {});
  ASSERT_FALSE(plan.views.empty());
  EXPECT_EQ(plan.stop_reason, "");
  EXPECT_EQ(plan.uncovered, before);
  EXPECT_EQ(plan.views.front().id, 7);
  Evaluate(WithViews(Ring(), plan), &world.map);
  EXPECT_LT(world.map.Count(CoverageClass::kUncovered), before / 4);
}

TEST(Submodular, NeedsFewerPhotosThanTheSweep) {
  NextBestViewOptions plane_sweep;
  plane_sweep.strategy = "plane_sweep";
  const std::size_t sweep = PhotosToCover(0.95, plane_sweep);
  const std::size_t submodular = PhotosToCover(0.95, Submodular());
  RecordProperty("plane_sweep", static_cast<int>(sweep));
  RecordProperty("submodular", static_cast<int>(submodular));
  EXPECT_LE(static_cast<double>(submodular), 0.8 * static_cast<double>(sweep));
}

TEST(Submodular, LooksDownOnARoof) {
  HallWorld world;
  world.Uncover({Eigen::Vector3d(-6, -4, 11.9), Eigen::Vector3d(6, 4, 12.1)});
  NextBestViewOptions options = Submodular();
  options.min_shared_features = 0;
  const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
  ASSERT_FALSE(plan.views.empty());
  EXPECT_LT(std::min_element(plan.views.begin(), plan.views.end(),
                             [](const PlannedView& a, const PlannedView& b) {
                               return a.direction.pitch_rad < b.direction.pitch_rad;
                             })
                ->direction.pitch_rad,
            DegToRad(-45));
  Evaluate(WithViews(Ring(), plan), &world.map);
  for (const IsoPoint& point : world.map.points) {
    if (point.position.z() > 11.9 && std::abs(point.position.x()) < 5 &&
        std::abs(point.position.y()) < 3) {
      EXPECT_EQ(point.coverage, CoverageClass::kCovered);
    }
  }
}

TEST(Submodular, KeepsItsBudgets) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = Submodular();
  options.num_views = 40;
  const ViewPlanResult free = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
  ASSERT_GT(free.tour_length_m, 60);
  for (const bool is_return : {false, true}) {
    options.return_to_start = is_return;
    options.max_tour_length_m = 60;
    options.max_tour_duration_s = 0;
    const ViewPlanResult near = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
    EXPECT_FALSE(near.views.empty());
    EXPECT_LT(near.views.size(), free.views.size());
    EXPECT_LE(near.tour_length_m, 60);
    Eigen::Vector3d place = CameraCenter(Ring().back().cam_from_world);
    const Eigen::Vector3d start = place;
    double length = 0;
    for (const PlannedView& view : near.views) {
      length += (view.position - place).norm();
      place = view.position;
    }
    if (is_return) length += (start - place).norm();
    EXPECT_NEAR(length, near.tour_length_m, 1e-9);
    options.max_tour_length_m = 0;
    options.max_tour_duration_s = 45;
    const ViewPlanResult quick = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
    EXPECT_FALSE(quick.views.empty());
    EXPECT_LE(quick.tour_duration_s, 45);
    EXPECT_LE(quick.views.size(), 9u);  // 5 s of turning and hovering each
  }
}

TEST(Submodular, PlannedViewsShareEnoughFeatures) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = Submodular();
  options.num_views = 20;
  const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
  ASSERT_EQ(plan.shared_features.size(), plan.views.size());
  for (const double shared : plan.shared_features) EXPECT_GE(shared, options.min_shared_features);
  // Features that are only matched from where photos were, and no place near to any.
  options.max_feature_angle_deg = 0.01;
  const std::vector<PosedPhoto> photos = Ring();
  ViewPlanInput input{world.map, world.mesh, photos};
  input.camera = kCamera;
  input.may_fly = [&](const Eigen::Vector3d& position) {
    return std::all_of(photos.begin(), photos.end(), [&](const PosedPhoto& photo) {
      return (CameraCenter(photo.cam_from_world) - position).norm() > 0.5;
    });
  };
  const ViewPlanResult none = PlanNextViews(input, options, {});
  EXPECT_TRUE(none.views.empty());
  EXPECT_EQ(none.stop_reason, "nothing_reachable");
  EXPECT_NE(none.explanation.find("min_shared_features"), std::string::npos) << none.explanation;
}

TEST(Submodular, IsTheSameWithOneThreadAndMany) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  const ViewPlanResult many = Plan(world.map, world.mesh, Ring(), kCamera, 0, Submodular(), {});
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const ViewPlanResult one = Plan(world.map, world.mesh, Ring(), kCamera, 0, Submodular(), {});
  ASSERT_EQ(one.views.size(), many.views.size());
  for (std::size_t i = 0; i < one.views.size(); ++i) {
    EXPECT_EQ(one.views[i].position, many.views[i].position);
    EXPECT_EQ(one.views[i].direction.pitch_rad, many.views[i].direction.pitch_rad);
  }
}

TEST(Submodular, PrefersTheSunBehindTheCamera) {
  HallWorld world;
  for (const double side : {-5.0, 5.0}) {
    world.Uncover({Eigen::Vector3d(-5, side - 0.1, 4), Eigen::Vector3d(5, side + 0.1, 10)});
  }
  NextBestViewOptions options = Submodular();
  options.num_views = 1;
  options.sun_weight = 0.9;
  options.sun_elevation_deg = 10;
  for (const double azimuth_deg : {0.0, 180.0}) {  // the sun in the north, then in the south
    options.sun_azimuth_deg = azimuth_deg;
    const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
    ASSERT_FALSE(plan.views.empty());
    for (const PlannedView& view : plan.views) {
      const double northward = DirectionInWorld(view.direction).y();
      EXPECT_TRUE(azimuth_deg == 0 ? northward < 0 : northward > 0) << azimuth_deg;
    }
  }
}

TEST(Baselines, RandomViewsChangeWithTheSeedOnly) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = Submodular();
  options.strategy = "random";
  const auto places = [&](std::uint64_t seed) {
    options.seed = seed;
    std::vector<Eigen::Vector3d> positions;
    for (const PlannedView& view :
         Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {}).views) {
      positions.push_back(view.position);
    }
    return positions;
  };
  const std::vector<Eigen::Vector3d> first = places(1);
  EXPECT_EQ(first.size(), static_cast<std::size_t>(options.num_views));
  EXPECT_EQ(first, places(1));
  EXPECT_NE(first, places(2));
}

TEST(Baselines, NextFarthestPointSpreadsItsViews) {
  HallWorld world;
  Evaluate(Ring(), &world.map);
  NextBestViewOptions options = Submodular();
  options.min_shared_features = 0;
  const auto nearest_pair = [&](const std::string& strategy) {
    options.strategy = strategy;
    const ViewPlanResult plan = Plan(world.map, world.mesh, Ring(), kCamera, 0, options, {});
    EXPECT_EQ(plan.views.size(), static_cast<std::size_t>(options.num_views));
    double nearest = 1e9;
    const std::vector<PosedPhoto> all = WithViews(Ring(), plan);
    for (std::size_t i = Ring().size(); i < all.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        nearest = std::min(
            nearest,
            (CameraCenter(all[i].cam_from_world) - CameraCenter(all[j].cam_from_world)).norm());
      }
    }
    return nearest;
  };
  EXPECT_GT(nearest_pair("next_farthest_point"), 2 * nearest_pair("random"));
}

}  // namespace
}  // namespace colmap_ext
