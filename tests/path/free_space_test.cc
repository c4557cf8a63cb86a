#include "colmap_ext/path/free_space.h"

#include <gtest/gtest.h>

#include "path/box_world.h"

namespace colmap_ext {
namespace {

// Flat ground of 200 m, and a block of 10 m in the middle.
const std::vector<Eigen::AlignedBox3d> kBlock = {
    {Eigen::Vector3d(-100, -100, -1), Eigen::Vector3d(100, 100, 0)},
    {Eigen::Vector3d(-5, -5, 0), Eigen::Vector3d(5, 5, 10)}};

TEST(FreeSpace, KnowsWhatIsHighAboveTheSurface) {
  const FreeSpace space(MeshOf(kBlock), {}, {}, {5, 3});
  EXPECT_TRUE(space.IsKnownFree({0, 0, 15.6}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({0, 0, 15.4}, 0.5));
}

TEST(FreeSpace, KnowsTheHullOfWhatWasFlown) {
  const std::vector<Eigen::Vector3d> flown = {
      {-10, -10, 8}, {10, -10, 8}, {10, 10, 8}, {-10, 10, 8}};
  const FreeSpace space(MeshOf(kBlock), {}, flown, {5, 2});
  EXPECT_TRUE(space.IsKnownFree({9, 9, 8}, 0.5));
  EXPECT_TRUE(space.IsKnownFree({0, -11, 8.5}, 0.5));
  EXPECT_TRUE(space.IsKnownFree({-8, 0, 6.6}, 0.5));
  EXPECT_FALSE(space.IsKnownFree({-8, 0, 6.4}, 0.5));    // nearer to the border than its radius
  EXPECT_FALSE(space.IsKnownFree({-12.1, 0, 8}, 0.01));  // outside
  EXPECT_FALSE(space.IsKnownFree({-12, -12, 8}, 0.01));  // beyond a corner by 2.8 m
}

TEST(FreeSpace, HasNoHullWithoutAMargin) {
  const FreeSpace space(MeshOf(kBlock), {}, {{-10, 0, 8}, {10, 0, 8}}, {5, 0});
  EXPECT_FALSE(space.IsKnownFree({0, 0, 8}, 0));
}

TEST(FreeSpace, KnowsWhatAPhotoSawPast) {
  // 30 m south of the block, 5 m high, looking north and slightly down: wall and ground are seen.
  const FreeSpace space(MeshOf(kBlock), {PhotoAt({0, -30, 5}, 0, -20)}, {}, {5, 0});
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
  const FreeSpace space(MeshOf(far_block), {PhotoAt({0, 0, 5}, 180, 0)}, {}, {5, 0});
  EXPECT_FALSE(space.IsKnownFree({0, -10, 5}, 0.5));  // straight ahead: sky
  const FreeSpace towards(MeshOf(far_block), {PhotoAt({0, 0, 5}, 0, 0)}, {}, {5, 0});
  EXPECT_TRUE(towards.IsKnownFree({0, 30, 5}, 0.5));
  EXPECT_FALSE(towards.IsKnownFree({8, 30, 5}, 0.5));  // passes the block
}

TEST(FreeSpace, KnowsNothingWithoutSurfacePhotosAndFlight) {
  const FreeSpace space(TriangleMesh{}, {}, {}, {5, 3});
  EXPECT_FALSE(space.IsKnownFree({0, 0, 1000}, 0));
}

}  // namespace
}  // namespace colmap_ext
