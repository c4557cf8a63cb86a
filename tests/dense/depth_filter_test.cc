#include "colmap_ext/dense/depth_filter.h"

#include <gtest/gtest.h>

#include <random>

#include "colmap_ext/dense/depth_fusion.h"
#include "dense/wall_survey.h"

namespace colmap_ext {
namespace {

const PinholeCamera kFilteredCamera{80, 60, 70, 70, 40, 30};

// A camera at `position` looking north at the plane y = `north`, depth exact.
DepthView PlaneView(const Eigen::Vector3d& position, double north) {
  DepthView view{kFilteredCamera, CamFromWorld(position, {0, 0}), cv::Mat()};
  view.inverse_depth = cv::Mat(kFilteredCamera.height, kFilteredCamera.width, CV_32F,
                               cv::Scalar(1 / (north - position.y())));
  return view;
}

TEST(ConfirmDepth, KeepsWhatEnoughPhotosAgreeOn) {
  DenseStereoOptions options;
  const DepthView view = PlaneView({0, 0, 0}, 10);
  const std::vector<DepthView> agreeing = {PlaneView({1, 0, 0}, 10), PlaneView({-1, 0, 0}, 10)};
  options.min_photos = 3;
  const ConfirmedDepth both = ConfirmDepth(view, agreeing, options);
  EXPECT_EQ(both.photos.at<unsigned char>(30, 40), 3);
  EXPECT_NEAR(both.inverse_depth.at<float>(30, 40), 0.1, 1e-7);
  // The left border is outside of the right photo.
  EXPECT_EQ(both.photos.at<unsigned char>(30, 1), 0);
  EXPECT_EQ(ConfirmDepth(view, {agreeing[0]}, options).photos.at<unsigned char>(30, 40), 0);
  options.min_photos = 1;
  EXPECT_EQ(ConfirmDepth(view, {}, options).photos.at<unsigned char>(30, 40), 1);
}

TEST(ConfirmDepth, DropsWhatOthersLookThrough) {
  DenseStereoOptions options;
  options.min_photos = 1;
  const DepthView ghost = PlaneView({0, 0, 0}, 6);
  const DepthView wall = PlaneView({0.5, 0, 0}, 10);
  EXPECT_EQ(ConfirmDepth(ghost, {wall}, options).photos.at<unsigned char>(30, 40), 0);
  // Something nearer in the other photo hides the point and says nothing about it.
  EXPECT_EQ(ConfirmDepth(wall, {ghost}, options).photos.at<unsigned char>(30, 40), 1);
}

TEST(AskWitness, ComparesDepthAndReprojection) {
  DenseStereoOptions options;
  const DepthView view = PlaneView({0, 0, 0}, 10);
  const Eigen::Vector2d pixel(40, 30);
  const Eigen::Vector3d point(0, 10, 0);
  using Verdict = DepthWitness::Verdict;
  const auto verdict = [&](double north) {
    return AskWitness(view, pixel, point, PlaneView({1, 0, 0}, north), options).verdict;
  };
  EXPECT_EQ(verdict(10.05), Verdict::kConfirms);
  EXPECT_EQ(verdict(10.2), Verdict::kNothing);
  EXPECT_EQ(verdict(10.5), Verdict::kContradicts);
  EXPECT_EQ(verdict(9.5), Verdict::kNothing);
  const DepthWitness witness = AskWitness(view, pixel, point, PlaneView({1, 0, 0}, 10.05), options);
  EXPECT_NEAR(witness.depth, 10.05, 1e-5);
  EXPECT_NEAR(witness.point_in_world.y(), 10.05, 1e-5);
  options.max_reprojection_px = 0.01;
  EXPECT_EQ(verdict(10.05), Verdict::kNothing);
}

// Inverse depth of the plane through (0, 0, z) with the given normal in the camera frame.
cv::Mat PlaneMap(const Eigen::Vector3d& normal, double z) {
  cv::Mat map(kFilteredCamera.height, kFilteredCamera.width, CV_32F);
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const double value = normal.dot(kFilteredCamera.Ray({x + 0.5, y + 0.5})) / (normal.z() * z);
      map.at<float>(y, x) = static_cast<float>(std::max(0.0, value));
    }
  }
  return map;
}

TEST(FitPlanes, GivesTheExactNormalAndDepthOfAPlane) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.6, -0.8).normalized();
  const cv::Mat map = PlaneMap(normal, 12);
  const PlaneMaps planes = FitPlanes(kFilteredCamera, map, DenseStereoOptions());
  for (const cv::Point p : {cv::Point(40, 30), cv::Point(12, 45), cv::Point(0, 30)}) {
    const cv::Vec3f n = planes.normal.at<cv::Vec3f>(p);
    EXPECT_GT(normal.dot(Eigen::Vector3d(n[0], n[1], n[2])), 1 - 1e-5);
    EXPECT_NEAR(planes.inverse_depth.at<float>(p), map.at<float>(p), 1e-6);
  }
}

TEST(FitPlanes, SmoothsNoiseAndKeepsEdges) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 2e-4F);
  cv::Mat map(kFilteredCamera.height, kFilteredCamera.width, CV_32F);
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      map.at<float>(y, x) = (x < 40 ? 0.1F : 0.15F) + noise(random);
    }
  }
  const PlaneMaps planes = FitPlanes(kFilteredCamera, map, DenseStereoOptions());
  double before = 0, after = 0;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const double truth = x < 40 ? 0.1 : 0.15;
      before += std::pow(map.at<float>(y, x) - truth, 2);
      after += std::pow(planes.inverse_depth.at<float>(y, x) - truth, 2);
    }
  }
  EXPECT_LT(after, 0.1 * before);  // variance; 49 pixels give 1/49 inside, less at edges
}

TEST(FitPlanes, DropsCrumbsAndGrazingPlanes) {
  cv::Mat crumbs = cv::Mat::zeros(kFilteredCamera.height, kFilteredCamera.width, CV_32F);
  crumbs(cv::Rect(10, 10, 2, 2)).setTo(0.1);
  crumbs(cv::Rect(30, 10, 9, 1)).setTo(0.1);  // a line has no plane
  EXPECT_EQ(
      cv::countNonZero(FitPlanes(kFilteredCamera, crumbs, DenseStereoOptions()).inverse_depth), 0);
}

FusionView FusionPlane(const Eigen::Vector3d& position, double north, int index) {
  FusionView view;
  view.depth = PlaneView(position, north);
  view.normal =
      cv::Mat(kFilteredCamera.height, kFilteredCamera.width, CV_32FC3, cv::Scalar(0, 0, -1));
  view.photos = cv::Mat(kFilteredCamera.height, kFilteredCamera.width, CV_8U, cv::Scalar(2));
  view.bgr =
      cv::Mat(kFilteredCamera.height, kFilteredCamera.width, CV_8UC3, cv::Scalar(10, 20, 30));
  view.photo_index = index;
  return view;
}

TEST(FuseView, GivesEachPlaceOnceFromThePhotoThatSawItFinest) {
  DenseStereoOptions options;
  options.fusion_step_px = 1;
  options.max_depth_error = 0.02;
  const FusionView near = FusionPlane({0, 2, 0}, 10.04, 0), far = FusionPlane({0, 0, 0}, 10.0, 1);
  const OrientedPoints from_near = FuseView(near, {far}, options);
  EXPECT_EQ(from_near.size(), 80U * 60U);
  const OrientedPoints from_far = FuseView(far, {near}, options);
  // The far photo sees more: the frame around what the near one covers, 1 - (8/10)² of it.
  EXPECT_NEAR(static_cast<double>(from_far.size()), 80 * 60 * (1 - 0.64), 250);
  // Weights 1/8² and 1/10².
  const double expected = (10.04 / 64.6 + 10.0 / 100) / (1 / 64.6 + 1 / 100.0);
  const OrientedPoint& middle = from_near[30 * 80 + 40];
  EXPECT_NEAR(middle.position.y(), expected, 1e-3);
  EXPECT_LT((middle.normal - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6);
  EXPECT_EQ(middle.color.x(), 30);
  EXPECT_FLOAT_EQ(middle.confidence, 0.5F);
  EXPECT_EQ(middle.photo_index, 0);
}

TEST(FuseView, StepsOverPixelsAndBreaksTiesByIndex) {
  DenseStereoOptions options;
  options.fusion_step_px = 4;
  const FusionView a = FusionPlane({0, 0, 0}, 10, 0), b = FusionPlane({0, 0, 0}, 10, 1);
  EXPECT_EQ(FuseView(a, {b}, options).size(), 20U * 15U);
  EXPECT_EQ(FuseView(b, {a}, options).size(), 0U);
}

}  // namespace
}  // namespace colmap_ext
