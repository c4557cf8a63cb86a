#include "colmap_ext/eval/camera_poses.h"

#include <gtest/gtest.h>

#include <fstream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

std::filesystem::path WriteText(const std::string& text) {
  const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path = std::filesystem::path(::testing::TempDir()) / ("poses_" + name + ".txt");
  std::ofstream(path) << text;
  return path;
}

TEST(ReadCameraPoses, GivesPosesByName) {
  const auto poses =
      ReadCameraPoses(WriteText("b.jpg 0 0 0 1 -4 5 6\na photo.jpg 1 0 0 0 1 2 3\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses.at("a photo.jpg").translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(poses.at("b.jpg").rotation.z(), 1.0);
  EXPECT_THROW(ReadCameraPoses("/nonexistent/poses.txt"), Error);
}

}  // namespace
}  // namespace colmap_ext
