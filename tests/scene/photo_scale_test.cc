#include "colmap_ext/scene/photo_scale.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

PhotoSet OnePhoto(int width, int height, bool with_pixels) {
  PosedPhoto photo;
  photo.camera = {width, height, 100.0, 110.0, width / 2.0, height / 2.0};
  if (with_pixels) photo.bgr = cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 20, 30));
  PhotoSet set;
  set.photos.push_back(photo);
  return set;
}

TEST(DownscalePhotos, KeepsThePointUnderAPixel) {
  PhotoSet set = OnePhoto(200, 100, true);
  const Eigen::Vector3d point(0.2, -0.1, 1.0);
  const Eigen::Vector2d before = set.photos[0].camera.Project(point);
  DownscalePhotos(50, &set);
  const PosedPhoto& photo = set.photos[0];
  EXPECT_EQ(photo.bgr.cols, 50);
  EXPECT_EQ(photo.bgr.rows, 25);
  EXPECT_EQ(photo.camera.width, 50);
  EXPECT_TRUE(photo.camera.Project(point).isApprox(0.25 * before, 1e-12));
  EXPECT_EQ(photo.bgr.at<cv::Vec3b>(3, 3), cv::Vec3b(10, 20, 30));
}

TEST(DownscalePhotos, LeavesSmallPhotosAlone) {
  PhotoSet set = OnePhoto(200, 100, true);
  DownscalePhotos(200, &set);
  EXPECT_EQ(set.photos[0].camera.width, 200);
  EXPECT_EQ(set.photos[0].bgr.cols, 200);
}

TEST(DownscalePhotos, WorksWithoutPixels) {
  PhotoSet set = OnePhoto(200, 100, false);
  DownscalePhotos(100, &set);
  EXPECT_EQ(set.photos[0].camera.height, 50);
  EXPECT_TRUE(set.photos[0].bgr.empty());
}

}  // namespace
}  // namespace colmap_ext
