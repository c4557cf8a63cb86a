#include "sfm/point_colors.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

using Color = Eigen::Matrix<std::uint8_t, 3, 1>;

// Two photos, red and blue (one with a green pixel at (2, 1)), and three points: one in both, one
// on the green pixel, one in the first that has a colour already.
Reconstruction ThreePoints(const TestFolder& folder) {
  cv::Mat3b red(8, 8, cv::Vec3b(0, 0, 200)), blue(8, 8, cv::Vec3b(100, 0, 0));
  blue(1, 2) = cv::Vec3b(0, 250, 0);
  cv::imwrite((folder / "red.png").string(), red);
  cv::imwrite((folder / "blue.png").string(), blue);
  Reconstruction model;
  model.images[1].name = "red.png";
  model.images[1].keypoints = {{{4.5, 4.5}, 1}, {{0, 0}, kInvalidPoint3DId}, {{8, 8}, 3}};
  model.images[2].name = "blue.png";
  model.images[2].keypoints = {{{2.9, 1.1}, 2}, {{6, 6}, 1}};
  for (const Point3DId id : {1, 2, 3}) model.points[id].position.setZero();
  model.points[3].color = Color(1, 2, 3);
  return model;
}

TEST(ColorPoints, IsTheMeanOfThePixelsThatShowThem) {
  const TestFolder folder;
  Reconstruction model = ThreePoints(folder);
  ColorPoints(folder.path(), {"red.png", "blue.png"}, &model);
  EXPECT_EQ(model.points[1].color, Color(100, 0, 50));
  EXPECT_EQ(model.points[2].color, Color(0, 250, 0));
  EXPECT_EQ(model.points[3].color, Color(1, 2, 3));
}

TEST(ColorPoints, OnlyTheGivenPhotosCount) {
  const TestFolder folder;
  Reconstruction model = ThreePoints(folder);
  ColorPoints(folder.path(), {"red.png"}, &model);
  EXPECT_EQ(model.points[1].color, Color(200, 0, 0));
  EXPECT_EQ(model.points[2].color, Color(0, 0, 0));
}

TEST(ColorPoints, APhotoThatIsGoneColoursNothing) {
  const TestFolder folder;
  Reconstruction model = ThreePoints(folder);
  std::filesystem::remove(folder / "blue.png");
  ColorPoints(folder.path(), {"red.png", "blue.png"}, &model);
  EXPECT_EQ(model.points[1].color, Color(200, 0, 0));
  EXPECT_EQ(model.points[2].color, Color(0, 0, 0));
}

}  // namespace
}  // namespace colmap_ext
