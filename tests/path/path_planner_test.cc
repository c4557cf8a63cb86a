#include "colmap_ext/path/path_planner.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <random>
#include <set>

#include "colmap_ext/scene/image_list.h"
#include "colmap_ext/util/error.h"
#include "path/box_world.h"

namespace colmap_ext {
namespace {

std::vector<int> ViewsOf(const FlightPath& path) {
  std::vector<int> ids;
  for (const Waypoint& waypoint : path.waypoints) {
    if (waypoint.view_id >= 0) ids.push_back(waypoint.view_id);
  }
  return ids;
}

TEST(PlanPath, GoesStraightWhereItCan) {
  const FlightPath path =
      PlanPath({-20, -20, 5}, {ViewAt(3, 20, -20, 5, 1.0)}, MeshOf(kBlock), {}, Everywhere(), {});
  ASSERT_EQ(path.waypoints.size(), 2u);
  EXPECT_EQ(path.waypoints[0].view_id, -1);
  EXPECT_EQ(path.waypoints[1].view_id, 3);
  EXPECT_NEAR(path.length_m, 40, 1e-9);
  EXPECT_NEAR(path.min_clearance_m, 15, 0.03);
  // At 3 m/s, with 2 m/s² at both ends; the photo takes 4 s.
  EXPECT_NEAR(path.duration_s, 40 / 3.0 + 3 / 2.0 + 4, 1e-9);
  EXPECT_TRUE(path.dropped_view_ids.empty());
}

TEST(PlanPath, GoesAroundTheBlockOnAboutTheShortestWay) {
  PathOptions options = Everywhere();
  options.cell_size_m = 0.5;
  const FlightPath path =
      PlanPath({-20, 0, 5}, {ViewAt(0, 20, 0, 5)}, MeshOf(kBlock), {}, options, {});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{0});
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), path.min_clearance_m - 1e-6);
  EXPECT_GE(path.min_clearance_m, options.safe_distance_m - 0.03);
  // Around the side the tangents to circles of 2 m at the corners give 41.9 m; the grid adds some.
  EXPECT_GT(path.length_m, 41.5);
  EXPECT_LT(path.length_m, 45);
}

TEST(PlanPath, ClimbsOverWhenTheSidesAreClosed) {
  const std::vector<Eigen::AlignedBox3d> wall = {
      {Eigen::Vector3d(-1, -100, 0), Eigen::Vector3d(1, 100, 12)}};
  const FlightPath path =
      PlanPath({-15, 0, 5}, {ViewAt(0, 15, 0, 5)}, MeshOf(wall), {}, Everywhere(), {});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{0});
  double top = 0;
  for (const Waypoint& waypoint : path.waypoints) top = std::max(top, waypoint.position.z());
  EXPECT_GE(top, 14);
  EXPECT_GE(SampledClearance(wall, path.waypoints), 2 - 1e-6);
}

TEST(PlanPath, SaysWhichViewsItDropsUnderACeiling) {
  const std::vector<Eigen::AlignedBox3d> wall = {
      {Eigen::Vector3d(-1, -100, 0), Eigen::Vector3d(1, 100, 12)}};
  PathOptions options = Everywhere();
  options.max_altitude_m = 13;
  const FlightPath path =
      PlanPath({-15, 0, 5}, {ViewAt(9, 15, 0, 5), ViewAt(4, -15, 6, 5), ViewAt(8, -15, 0, 14)},
               MeshOf(wall), {}, options, {});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{4});
  EXPECT_EQ(path.dropped_view_ids, (std::vector<int>{9, 8}));
}

TEST(PlanPath, DropsAViewThatIsTooNearToTheSurface) {
  const FlightPath path = PlanPath({-20, 0, 5}, {ViewAt(0, -6, 0, 5), ViewAt(1, -8, 0, 5)},
                                   MeshOf(kBlock), {}, Everywhere(), {});
  EXPECT_EQ(path.dropped_view_ids, std::vector<int>{0});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{1});
}

TEST(PlanPath, KeepsOutOfUnknownSpace) {
  std::vector<Eigen::AlignedBox3d> boxes = kBlock;
  boxes.emplace_back(Eigen::Vector3d(-100, -100, -1), Eigen::Vector3d(100, 100, 0));  // ground
  const TriangleMesh mesh = MeshOf(boxes);
  PathOptions options = Everywhere();
  options.unknown = "occupied";
  // Photos 4 m apart see all of what lies from 3.2 m before them; nearer, gaps are between them.
  options.flown_margin_m = 4;
  // Photos on a line south of the block; what lies north of it was never seen.
  std::vector<PosedPhoto> photos;
  for (double x = -20; x <= 20; x += 4) {
    photos.push_back(PhotoAt({x, -20, 6}, 0, -20));
    photos.push_back(PhotoAt({x, -20, 14}, 0, -20));
  }
  const std::vector<PlannedView> views = {ViewAt(0, 10, -19, 6), ViewAt(1, 0, 9, 2.5),
                                          ViewAt(2, 0, -10, 3), ViewAt(3, 0, 0, 13)};
  const FlightPath path = PlanPath({-20, -20, 6}, views, mesh, photos, options, {});
  // View 2: the photos saw the wall behind it. View 3 is above the top by the safe distance, and
  // reached over the top, which is known.
  EXPECT_EQ(path.dropped_view_ids, std::vector<int>{1}) << path.drop_reasons.back();
  for (const Waypoint& waypoint : path.waypoints) EXPECT_LT(waypoint.position.y(), 5);
  options.unknown = "free";
  EXPECT_TRUE(PlanPath({-20, -20, 6}, views, mesh, photos, options, {}).dropped_view_ids.empty());
}

// Two rows of photos that see nothing. Between and around those that a person vouches for the
// vehicle may fly; around its own it may not, but for where it was.
TEST(PlanPath, FliesUnseenSpaceOnlyAroundVouchedPhotos) {
  std::vector<PosedPhoto> photos;
  PathOptions options = Everywhere();
  options.unknown = "occupied";
  options.free_volume = "flown";
  options.flown_margin_m = 4;
  options.position_error_m = 0.3;
  options.vouched_photos.emplace();
  for (double x = -20; x <= 20; x += 4) {
    photos.push_back(PhotoAt({x, -20, 6}, 180, 30));
    photos.back().name = "person" + std::to_string(photos.size());
    options.vouched_photos->insert(photos.back().name);
  }
  for (double x = -20; x <= 20; x += 4) {
    photos.push_back(PhotoAt({x, -30, 6}, 180, 30));
    photos.back().name = "planned" + std::to_string(photos.size());
  }
  const Eigen::Vector3d start(-20, -20, 6);
  const std::vector<PlannedView> views = {ViewAt(0, 18, -21, 7), ViewAt(1, 0, -26, 6),
                                          ViewAt(2, 2, -31, 6)};
  const FlightPath path = PlanPath(start, views, MeshOf(kBlock), photos, options, {});
  EXPECT_EQ(path.dropped_view_ids, (std::vector<int>{1, 2}));
  const FreeSpace space = KnownSpace(SurfaceOf(kBlock), photos, start, options);
  EXPECT_TRUE(space.IsKnownFree({4, -30, 6}, 2 * options.position_error_m));
  EXPECT_FALSE(space.IsKnownFree({4, -30, 6}, 2 * options.position_error_m + 0.1));
  options.vouched_photos.reset();  // a person flew both
  EXPECT_TRUE(PlanPath(start, views, MeshOf(kBlock), photos, options, {}).dropped_view_ids.empty());
}

// The vehicle is 1.4 m beside the known space, then 3 m: further than it can be off.
TEST(PlanPath, LeavesAStartBesideWhatIsKnown) {
  PathOptions options = Everywhere();
  options.unknown = "occupied";
  options.free_volume = "-40,-40,3,-20,40,20";
  options.position_error_m = 0.5;
  const std::vector<PlannedView> views = {ViewAt(0, -30, 10, 8)};
  const FlightPath path = PlanPath({-18.6, 0, 8}, views, MeshOf(kBlock), {}, options, {});
  EXPECT_TRUE(path.dropped_view_ids.empty());
  ASSERT_GE(path.waypoints.size(), 3u);
  EXPECT_LT(path.waypoints[1].position.x(), -20.5);
  EXPECT_LT((path.waypoints[1].position - path.waypoints[0].position).norm(), 4.5);
  EXPECT_EQ(PlanPath({-16, 0, 8}, views, MeshOf(kBlock), {}, options, {}).dropped_view_ids.size(),
            1u);
}

// A pocket of known space that no way leads to, and one that is joined around a corner.
TEST(ReachablePositions, AreThoseThatPlanPathReaches) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(-40, 40), z(3, 12);
  PathOptions options = Everywhere();
  options.unknown = "occupied";
  options.position_error_m = 0.3;
  options.free_volume =
      "-40,-40,2,-8,-20,14;-40,-40,2,-28,40,14;-12,20,2,12,40,14;20,-40,2,40,0,14";
  const Eigen::Vector3d start(-12, -30, 8);
  const auto space =
      std::make_shared<const FreeSpace>(KnownSpace(SurfaceOf(kBlock), {}, start, options));
  const auto may_hover = FlyablePositions(space, options);
  const auto may_reach = ReachablePositions(space, start, options);
  EXPECT_TRUE(may_reach({-34, 34, 8}));  // around the corner
  EXPECT_FALSE(may_reach({0, 30, 8}));   // free, but apart
  EXPECT_FALSE(may_reach({30, -30, 8}));
  int reached = 0, apart = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d place(x(random), x(random), z(random));
    if (!may_hover(place)) continue;
    const FlightPath path =
        PlanPath(start, {ViewAt(0, place.x(), place.y(), place.z())}, *space, options, {});
    EXPECT_EQ(may_reach(place), path.dropped_view_ids.empty()) << place.transpose();
    ++(path.dropped_view_ids.empty() ? reached : apart);
  }
  EXPECT_GT(reached, 20);
  EXPECT_GT(apart, 10);
}

TEST(ReachablePositions, SayNothingOfAStartThatPlanPathRefuses) {
  const auto space =
      std::make_shared<const FreeSpace>(KnownSpace(SurfaceOf(kBlock), {}, {0, 0, 5}, Everywhere()));
  EXPECT_TRUE(ReachablePositions(space, {0, 0, 5}, Everywhere())({20, 0, 5}));
  EXPECT_THROW(ReachablePositions(space, {NAN, 0, 5}, Everywhere()), Error);
}

TEST(KnownSpace, DoesNotTakeTheStartForVouched) {
  PathOptions options = Everywhere();
  options.unknown = "occupied";
  options.free_volume = "flown";
  options.position_error_m = 0.5;
  const FreeSpace space = KnownSpace(SurfaceOf(kBlock), {}, {-20, 0, 5}, options);
  EXPECT_TRUE(space.IsKnownFree({-20, 0, 5}, options.position_error_m));
  EXPECT_FALSE(space.IsKnownFree({-22, 0, 5}, 0));
}

TEST(ReadVouchedPhotos, TakesTheListBeforeTheSessionsFirstFlight) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "vouched_photos_test";
  std::filesystem::create_directories(folder);
  WriteImageList({"a.jpg", "b.jpg"}, Workspace(folder).first_flight_txt());
  WriteImageList({"c.jpg"}, folder / "mine.txt");
  PathOptions options;
  ReadVouchedPhotos("", &options);
  EXPECT_FALSE(options.vouched_photos.has_value());
  ReadVouchedPhotos(folder, &options);
  EXPECT_FALSE(options.vouched_photos.has_value());
  options.vouch_planned_flights = false;
  ReadVouchedPhotos(folder, &options);
  EXPECT_EQ(options.vouched_photos, (std::set<std::string>{"a.jpg", "b.jpg"}));
  options.vouched_image_list_path = folder / "mine.txt";
  ReadVouchedPhotos(folder, &options);
  EXPECT_EQ(options.vouched_photos, std::set<std::string>{"c.jpg"});
  options.vouched_image_list_path = folder / "none.txt";
  EXPECT_THROW(ReadVouchedPhotos(folder, &options), Error);
  std::filesystem::remove_all(folder);
}

TEST(PlanPath, KeepsItsPromiseInRandomWorlds) {
  std::mt19937 random(77);
  std::uniform_real_distribution<double> place(-20, 20), size(0.03, 8);
  int flown = 0, dropped = 0;
  for (int trial = 0; trial < 25; ++trial) {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector3d low(place(random), place(random), 0);
      boxes.emplace_back(low, low + Eigen::Vector3d(size(random), size(random), 2 * size(random)));
    }
    std::vector<PlannedView> views;
    for (int i = 0; i < 6; ++i) {
      views.push_back(ViewAt(i, place(random), place(random), 3 + std::abs(place(random)) / 2));
    }
    PathOptions options = Everywhere();
    options.safe_distance_m = 1.5;
    const FlightPath path = PlanPath({-30, -30, 20}, views, MeshOf(boxes), {}, options, {});
    EXPECT_GE(SampledClearance(boxes, path.waypoints), path.min_clearance_m - 1e-4) << trial;
    EXPECT_GE(path.min_clearance_m, 1.5 - 0.03) << trial;
    EXPECT_GE(SampledClearance(boxes, path.waypoints), 1.5 - 1e-4) << trial;
    EXPECT_EQ(ViewsOf(path).size() + path.dropped_view_ids.size(), views.size());
    flown += static_cast<int>(ViewsOf(path).size());
    dropped += static_cast<int>(path.dropped_view_ids.size());
  }
  EXPECT_GT(flown, 50);
  EXPECT_GT(dropped, 5);
}

TEST(PlanPath, DoesNotFlyThroughAWireThatCellsMiss) {
  // Cells of 4 m and a wire of 3 cm: no cell centre is near it.
  const std::vector<Eigen::AlignedBox3d> wire = {
      {Eigen::Vector3d(-0.015, -200, 6.985), Eigen::Vector3d(0.015, 200, 7.015)}};
  PathOptions options = Everywhere();
  options.cell_size_m = 4;
  options.safe_distance_m = 1;
  const FlightPath path =
      PlanPath({-10, 0, 7}, {ViewAt(0, 10, 0, 7)}, MeshOf(wire), {}, options, {});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{0});
  EXPECT_GT(path.waypoints.size(), 2u);
  EXPECT_GE(SampledClearance(wire, path.waypoints), 1 - 1e-4);
}

TEST(PlanPath, RefusesAStartInsideAnObstacleButLeavesOneThatIsALittleTooNear) {
  const TriangleMesh mesh = MeshOf(kBlock);
  EXPECT_THROW(PlanPath({-5.2, 0, 5}, {ViewAt(0, -20, 0, 5)}, mesh, {}, Everywhere(), {}), Error);
  const FlightPath path =
      PlanPath({-6.5, 0, 5}, {ViewAt(0, -20, 0, 5)}, mesh, {}, Everywhere(), {});
  EXPECT_EQ(ViewsOf(path), std::vector<int>{0});
  EXPECT_NEAR(path.min_clearance_m, 1.5, 0.03);  // said honestly
  EXPECT_GE(SampledClearance(kBlock, path.waypoints), path.min_clearance_m - 1e-6);
}

TEST(PlanPath, HandlesNoViewsAndNoSurface) {
  const FlightPath empty = PlanPath({-20, 0, 5}, {}, MeshOf(kBlock), {}, Everywhere(), {});
  ASSERT_EQ(empty.waypoints.size(), 1u);
  EXPECT_EQ(empty.length_m, 0);
  EXPECT_EQ(empty.duration_s, 0);
  const FlightPath free =
      PlanPath({0, 0, 5}, {ViewAt(1, 3, 4, 5)}, TriangleMesh{}, {}, Everywhere(), {});
  EXPECT_NEAR(free.length_m, 5, 1e-12);
}

TEST(PlanPath, IsTheSameWithOneThreadAndMany) {
  std::vector<PlannedView> views;
  for (int i = 0; i < 8; ++i) {
    views.push_back(ViewAt(i, 14 * std::cos(2.4 * i), 14 * std::sin(2.4 * i), 5));
  }
  const FlightPath many = PlanPath({-20, 0, 5}, views, MeshOf(kBlock), {}, Everywhere(), {});
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const FlightPath one = PlanPath({-20, 0, 5}, views, MeshOf(kBlock), {}, Everywhere(), {});
  ASSERT_EQ(one.waypoints.size(), many.waypoints.size());
  for (std::size_t i = 0; i < one.waypoints.size(); ++i) {
    EXPECT_EQ(one.waypoints[i].position, many.waypoints[i].position);
    EXPECT_EQ(one.waypoints[i].view_id, many.waypoints[i].view_id);
  }
  EXPECT_EQ(one.min_clearance_m, many.min_clearance_m);
}

TEST(PlanPath, RefusesBadOptionsAndGridsThatAreTooLarge) {
  PathOptions options = Everywhere();
  options.safe_distance_m = 0;
  EXPECT_THROW(PlanPath({0, 0, 0}, {}, TriangleMesh{}, {}, options, {}), UsageError);
  options = Everywhere();
  options.unknown = "maybe";
  EXPECT_THROW(PlanPath({0, 0, 0}, {}, TriangleMesh{}, {}, options, {}), UsageError);
  options = Everywhere();
  options.cell_size_m = 0.01;
  EXPECT_THROW(PlanPath({-20, 0, 5}, {}, MeshOf(kBlock), {}, options, {}), Error);
  EXPECT_THROW(PlanPath({NAN, 0, 5}, {}, MeshOf(kBlock), {}, Everywhere(), {}), Error);
}

TEST(PlanPath, StopsWhenCancelled) {
  const std::atomic<bool> cancel{true};
  const JobControl job(nullptr, &cancel);
  EXPECT_THROW(PlanPath({-20, 0, 5}, {ViewAt(0, 20, 0, 5)}, MeshOf(kBlock), {}, Everywhere(), job),
               CancelledError);
}

TEST(RequireMetric, RefusesAModelWithoutMetres) {
  EXPECT_THROW(RequireMetric(WorldFrame{}), Error);
  EXPECT_NO_THROW(RequireMetric(WorldFrame{true, std::nullopt}));
}

}  // namespace
}  // namespace colmap_ext
