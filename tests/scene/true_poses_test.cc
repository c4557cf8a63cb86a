#include "colmap_ext/scene/true_poses.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/files.h"
#include "scene/damaged_text.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

TEST(TruePoses, ComeBackSorted) {
  const TestFolder folder;
  const Rigid3d a = CamFromWorld({1.0 / 3, -2, 7}, {0.3, -0.4});
  const Rigid3d b = CamFromWorld({5, 6, 7}, {-1, 0.2});
  WriteTruePoses({{"b photo.jpg", b}, {"a.jpg", a}}, folder / "poses.txt");
  const auto poses = ReadTruePoses(folder / "poses.txt");
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].name, "a.jpg");
  EXPECT_EQ(poses[1].name, "b photo.jpg");
  EXPECT_EQ(poses[0].cam_from_world.translation, a.translation);
  EXPECT_LT(poses[1].cam_from_world.rotation.angularDistance(b.rotation), 1e-15);
  EXPECT_EQ(PoseOfPhoto(poses).at("b photo.jpg").translation, b.translation);
}

TEST(TruePoses, CommentsBlankLinesAndRoundedQuaternionsAreRead) {
  const TestFolder folder;
  WriteFileAtomically(folder / "poses.txt",
                      "# name qw qx qy qz tx ty tz\n\n"
                      "a photo.jpg 0.708 0 0.707 0 1 2 3 # rest\r\nb.jpg 0 0 0 1 -4 5 6");
  const auto poses = PoseOfPhoto(ReadTruePoses(folder / "poses.txt"));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_NEAR(poses.at("a photo.jpg").rotation.norm(), 1, 1e-15);
  EXPECT_EQ(poses.at("b.jpg").translation, Eigen::Vector3d(-4, 5, 6));
}

TEST(TruePoses, UpdateReplacesAndAdds) {
  const TestFolder folder;
  const Rigid3d first = CamFromWorld({1, 2, 3}, {}), second = CamFromWorld({4, 5, 6}, {});
  UpdateTruePoses({{"a.jpg", first}, {"b.jpg", first}}, folder / "poses.txt");
  UpdateTruePoses({{"b.jpg", second}, {"c.jpg", second}}, folder / "poses.txt");
  const auto poses = ReadTruePoses(folder / "poses.txt");
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_TRUE(CameraCenter(poses[0].cam_from_world).isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(CameraCenter(poses[1].cam_from_world).isApprox(Eigen::Vector3d(4, 5, 6)));
}

TEST(TruePoses, BadLinesAreNamed) {
  const TestFolder folder;
  const auto expect = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(folder / "poses.txt", text);
    ExpectError([&] { ReadTruePoses(folder / "poses.txt"); }, {"poses.txt", message});
  };
  expect("a 1 0 0 0 1 2 3\nb 1 0 0 0 1 2\n", "line 2: expected 'name qw qx qy qz tx ty tz'");
  expect("a 1 0 0 0 1 2 x3\n", "line 1: 'x3' is not a number");
  expect("a 1 0 0 0 1 2 nan\n", "'nan'");
  expect("a 2 0 0 0 1 2 3\n", "quaternion");
  expect("a 0 0 0 0 1 2 3\n", "quaternion");
  expect("a 1 0 0 0 1 2 3\n\na 1 0 0 0 1 2 3\n", "line 3: photo a is named twice");
  EXPECT_THROW(ReadTruePoses(folder / "none.txt"), Error);
}

TEST(TruePoses, NamesThatWouldNotComeBackAreRefused) {
  const TestFolder folder;
  for (const char* name : {"", " a.jpg", "a  b.jpg", "a#b.jpg", "a\nb.jpg"}) {
    EXPECT_THROW(WriteTruePoses({{name, Rigid3d()}}, folder / "poses.txt"), Error) << name;
  }
}

TEST(TruePoses, DamagedFilesAreReadOrRefused) {
  const TestFolder folder;
  const std::string text = "# poses\na.jpg 1 0 0 0 1 2 3\nb c.jpg 0 1 0 0 -4.5 5e1 6\n";
  const int refused =
      CountRefused(text, folder / "poses.txt", 400, [](const auto& path) { ReadTruePoses(path); });
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 400);
}

}  // namespace
}  // namespace colmap_ext
