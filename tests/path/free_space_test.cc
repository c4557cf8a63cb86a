#include "colmap_ext/path/free_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "colmap_ext/util/error.h"
#include "path/box_world.h"

namespace colmap_ext {
namespace {

// Flat ground of 200 m, and a block of 10 m in the middle.
const std::vector<Eigen::AlignedBox3d> kBlockOnGround = {
    {Eigen::Vector3d(-100, -100, -1), Eigen::Vector3d(100, 100, 0)},
    {Eigen::Vector3d(-5, -5, 0), Eigen::Vector3d(5, 5, 10)}};

FreeSpaceOptions Vouched(double above_top_m, double flown_margin_m, double confident_m = 0) {
  FreeSpaceOptions options;
  options.above_top_m = above_top_m;
  options.flown_margin_m = flown_margin_m;
  options.confident_spacing_m = confident_m;
  return options;
}

TEST(FreeSpace, KnowsWhatIsHighAboveTheSurface) {
  const FreeSpace space(SurfaceOf(kBlockOnGround), {}, {}, Vouched(5, 3));
  EXPECT_TRUE(space.IsKnownFree({0, 0, 15.6}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({0, 0, 15.4}, 0.5));
}

TEST(FreeSpace, KnowsTheHullOfWhatWasFlown) {
  const std::vector<Eigen::Vector3d> flown = {
      {-10, -10, 8}, {10, -10, 8}, {10, 10, 8}, {-10, 10, 8}};
  const FreeSpace space(SurfaceOf(kBlockOnGround), {}, {flown, {}}, Vouched(5, 2));
  EXPECT_TRUE(space.IsKnownFree({9, 9, 8}, 0.5));
  EXPECT_TRUE(space.IsKnownFree({0, -11, 8.5}, 0.5));
  EXPECT_TRUE(space.IsKnownFree({-8, 0, 6.6}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({-8, 0, 6.4}, 0.5));    // nearer to the border than its radius
  EXPECT_FALSE(space.IsKnownFree({-12.1, 0, 8}, 0.01));  // outside
  EXPECT_FALSE(space.IsKnownFree({-12, -12, 8}, 0.01));  // beyond a corner by 2.8 m
}

TEST(FreeSpace, HasNoHullWithoutAMargin) {
  const FlownPlaces flown{{{-10, 0, 8}, {10, 0, 8}}, {}};
  const FreeSpace space(SurfaceOf(kBlockOnGround), {}, flown, Vouched(5, 0));
  EXPECT_FALSE(space.IsKnownFree({0, 0, 8}, 0));
}

TEST(FreeSpace, KnowsOnlyTheRoomAtVisitedPlaces) {
  FreeSpaceOptions options = Vouched(5, 3);
  options.visited_margin_m = 1;
  const FlownPlaces flown{{}, {{-10, -10, 8}, {10, -10, 8}, {10, 10, 8}, {-10, 10, 8}}};
  const FreeSpace space(SurfaceOf(kBlockOnGround), {}, flown, options);
  EXPECT_TRUE(space.IsKnownFree({10, 10, 8}, 1));
  EXPECT_TRUE(space.IsKnownFree({10.4, 10, 8}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({10.6, 10, 8}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({10, 0, 8}, 0));  // between two of them
  EXPECT_FALSE(space.IsKnownFree({0, 0, 8}, 0));
}

// What is taken for free without having been seen is decided by the vouched flight alone.
TEST(FreeSpace, DoesNotGrowByVisitedPlacesBeyondTheirOwnRoom) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-30, 30), height(1, 12), radius(0, 1);
  const auto any = [&] { return Eigen::Vector3d(place(random), place(random), height(random)); };
  FreeSpaceOptions options = Vouched(5, 4);
  options.visited_margin_m = 1;
  int vouched = 0, visited = 0;
  for (int world = 0; world < 20; ++world) {
    FlownPlaces flown;
    for (int i = 0; i < 6; ++i) flown.vouched.push_back(0.5 * any());
    const FreeSpace before(SurfaceOf(kBlockOnGround), {}, flown, options);
    for (int i = 0; i < 30; ++i) flown.visited.push_back(any());
    const FreeSpace after(SurfaceOf(kBlockOnGround), {}, flown, options);
    for (int i = 0; i < 500; ++i) {
      const double r = radius(random);
      const Eigen::Vector3d near = flown.visited[static_cast<std::size_t>(i) % 30];
      const Eigen::Vector3d center = i % 2 == 0 ? any() : Eigen::Vector3d(near + 0.02 * any());
      const bool is_at_visited =
          std::any_of(flown.visited.begin(), flown.visited.end(),
                      [&](const Eigen::Vector3d& p) { return (p - center).norm() + r <= 1; });
      ASSERT_EQ(after.IsKnownFree(center, r), before.IsKnownFree(center, r) || is_at_visited);
      vouched += before.IsKnownFree(center, r) ? 1 : 0;
      visited += is_at_visited ? 1 : 0;
    }
  }
  EXPECT_GT(vouched, 500);
  EXPECT_GT(visited, 500);
}

TEST(FreeSpace, KnowsWhatAPhotoSawPast) {
  // 30 m south of the block, 5 m high, looking north and slightly down: wall and ground are seen.
  const FreeSpace space(SurfaceOf(kBlockOnGround), {PhotoAt({0, -30, 5}, 0, -20)}, {},
                        Vouched(5, 0));
  EXPECT_TRUE(space.IsKnownFree({0, -10, 3}, 0.5));    // before the wall
  EXPECT_FALSE(space.IsKnownFree({0, -5.2, 3}, 0.5));  // reaches into the wall
  EXPECT_FALSE(space.IsKnownFree({0, 0, 3}, 0.5));     // inside the block
  EXPECT_FALSE(space.IsKnownFree({0, 12, 3}, 0.5));    // behind it
  EXPECT_FALSE(space.IsKnownFree({0, -40, 3}, 0.5));   // behind the camera
  EXPECT_FALSE(space.IsKnownFree({0, -10, 12}, 0.5));  // above the picture
}

TEST(FreeSpace, LearnsNothingFromRaysThatMeetNothing) {
  const std::vector<Eigen::AlignedBox3d> far_block = {
      {Eigen::Vector3d(-5, 50, 0), Eigen::Vector3d(5, 60, 10)}};
  const FreeSpace space(SurfaceOf(far_block), {PhotoAt({0, 0, 5}, 180, 0)}, {}, Vouched(5, 0));
  EXPECT_FALSE(space.IsKnownFree({0, -10, 5}, 0.5));  // straight ahead: sky
  const FreeSpace towards(SurfaceOf(far_block), {PhotoAt({0, 0, 5}, 0, 0)}, {}, Vouched(5, 0));
  EXPECT_TRUE(towards.IsKnownFree({0, 30, 5}, 0.5));
  EXPECT_FALSE(towards.IsKnownFree({8, 30, 5}, 0.5));  // passes the block
}

// Pixels of the planner's images are 27 cm wide here; the pole is 3 cm.
TEST(FreeSpace, AThinPoleHidesWhatIsBehindIt) {
  std::vector<Eigen::AlignedBox3d> boxes = {
      {Eigen::Vector3d(-50, 40, -50), Eigen::Vector3d(50, 41, 50)}};
  for (int i = 0; i < 40; ++i) {
    const double x = -2 + 0.1 * i;  // wherever it stands between the pixels' centres
    std::vector<Eigen::AlignedBox3d> with_pole = boxes;
    with_pole.emplace_back(Eigen::Vector3d(x, 20, -50), Eigen::Vector3d(x + 0.03, 20.03, 50));
    const FreeSpace space(SurfaceOf(with_pole), {PhotoAt({0, 0, 0}, 0, 0)}, {}, Vouched(-1, 0));
    const double behind = 30.0 / 20.0 * (x + 0.015);
    EXPECT_FALSE(space.IsKnownFree({behind, 30, 0}, 0.2)) << x;
    EXPECT_TRUE(space.IsKnownFree({x + 0.015, 15, 0}, 0.2)) << x;
    EXPECT_TRUE(space.IsKnownFree({behind + 2, 30, 0}, 0.2)) << x;
  }
}

TEST(FreeSpace, SurfaceThatIsNotConfidentFreesNothing) {
  Surface surface = SurfaceOf(kBlockOnGround);
  surface.sample_spacing_m.assign(surface.mesh.vertices.size(), 0.5);
  const std::vector<PosedPhoto> photos = {PhotoAt({0, -30, 5}, 0, -20)};
  EXPECT_TRUE(FreeSpace(surface, photos, {}, Vouched(5, 0, 1.0)).IsKnownFree({0, -10, 3}, 0.5));
  EXPECT_FALSE(FreeSpace(surface, photos, {}, Vouched(5, 0, 0.4)).IsKnownFree({0, -10, 3}, 0.5));
  surface.sample_spacing_m.pop_back();
  EXPECT_THROW(FreeSpace(surface, photos, {}, Vouched(5, 0, 1.0)), Error);
}

TEST(SetFreeVolume, NamesWhatThePilotVouchesFor) {
  FreeSpaceOptions options;
  EXPECT_TRUE(SetFreeVolume("flown;above_top", &options).empty());
  EXPECT_EQ(options.flown_margin_m, 5);
  EXPECT_EQ(options.above_top_m, 5);
  const auto files = SetFreeVolume("10,10,9,0,0,3; yard.geojson", &options);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(options.flown_margin_m, 0);
  const FreeSpace space(SurfaceOf(kBlockOnGround), {}, {{{0, -50, 8}}, {}}, options);
  EXPECT_TRUE(space.IsKnownFree({5, 5, 6}, 2.9));
  EXPECT_FALSE(space.IsKnownFree({5, 5, 6}, 3.1));
  EXPECT_FALSE(space.IsKnownFree({0, -50, 8}, 0.1));
  EXPECT_FALSE(space.IsKnownFree({0, 0, 100}, 0.1));
  SetFreeVolume("none", &options);
  EXPECT_LT(options.above_top_m, 0);
  EXPECT_THROW(SetFreeVolume("everything", &options), UsageError);
  EXPECT_THROW(SetFreeVolume("1,2,3,4,5", &options), UsageError);
}

TEST(FreeSpace, KnowsNothingWithoutSurfacePhotosAndFlight) {
  const FreeSpace space(Surface{}, {}, {}, Vouched(5, 3));
  EXPECT_FALSE(space.IsKnownFree({0, 0, 1000}, 0));
}

}  // namespace
}  // namespace colmap_ext
