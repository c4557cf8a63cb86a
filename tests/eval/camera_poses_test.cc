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

TEST(ReadCameraPoses, ReadsNamesWithSpacesAndNormalises) {
  const auto poses = ReadCameraPoses(WriteText(
      "# name qw qx qy qz tx ty tz\n\na photo.jpg 2 0 0 0 1 2 3\nb.jpg 0 0 0 1 -4 5 6\r\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses.at("a photo.jpg").rotation.w(), 1.0);
  EXPECT_EQ(poses.at("a photo.jpg").translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(poses.at("b.jpg").rotation.z(), 1.0);
}

TEST(ReadCameraPoses, ErrorsNameFileAndLine) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      ReadCameraPoses(WriteText(text));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("# x\na 1 0 0 0 1 2\n").find(".txt:2"), std::string::npos);
  EXPECT_NE(message("a 1 0 0 0 1 2 x3\n").find("'x3' is not a number"), std::string::npos);
  EXPECT_NE(message("a 1 0 0 0 1 2 nan\n").find("'nan'"), std::string::npos);
  EXPECT_NE(message("a 0 0 0 0 1 2 3\n").find("quaternion"), std::string::npos);
  EXPECT_NE(message("a 1 0 0 0 1 2 3\na 1 0 0 0 1 2 3\n").find("twice"), std::string::npos);
  EXPECT_THROW(ReadCameraPoses("/nonexistent/poses.txt"), Error);
}

}  // namespace
}  // namespace colmap_ext
