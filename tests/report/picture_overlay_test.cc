#include "colmap_ext/report/picture_overlay.h"

#include <gtest/gtest.h>

#include "report/analytic_scene.h"

namespace colmap_ext {
namespace {

const cv::Size kPictureSize(320, 200);

// How far a pixel is from another picture's.
int Change(const cv::Mat& a, const cv::Mat& b, int y, int x) {
  int largest = 0;
  for (int k = 0; k < 3; ++k) {
    largest = std::max(largest, std::abs(a.at<cv::Vec3b>(y, x)[k] - b.at<cv::Vec3b>(y, x)[k]));
  }
  return largest;
}

class OverlayTest : public ::testing::Test {
 protected:
  void SetUp() override {
    picture_ = RenderMesh(scene_.mesh, FaceColors(scene_.face_colors), LookingNorth(kPictureSize));
    before_ = picture_.bgr.clone();
  }

  SphereAndWall scene_;
  Picture picture_;
  cv::Mat before_;
};

TEST_F(OverlayTest, PathIsHiddenBehindTheSphere) {
  // Level, between sphere and wall, at the height of the camera: row 100.
  const StrokeStyle style{.color = {0, 1, 0}, .width_px = 3, .opacity = 1, .hidden_opacity = 0};
  DrawPolylines({{{-2.5, 8, 0}, {2.5, 8, 0}}}, style, &picture_);
  EXPECT_EQ(picture_.bgr.at<cv::Vec3b>(100, 80), cv::Vec3b(0, 255, 0));  // before the wall
  EXPECT_EQ(picture_.bgr.at<cv::Vec3b>(100, 240), cv::Vec3b(0, 255, 0));
  EXPECT_EQ(Change(picture_.bgr, before_, 100, 160), 0);  // behind the sphere
  EXPECT_EQ(Change(picture_.bgr, before_, 100, 40), 0);   // beyond its end
  EXPECT_EQ(Change(picture_.bgr, before_, 90, 80), 0);
}

TEST_F(OverlayTest, HiddenPartsAreDimmed) {
  const StrokeStyle style{.color = {0, 1, 0}, .width_px = 3, .opacity = 1, .hidden_opacity = 0.3};
  DrawPolylines({{{-2.5, 8, 0}, {2.5, 8, 0}}}, style, &picture_);
  const double before = before_.at<cv::Vec3b>(100, 160)[1];
  EXPECT_NEAR(picture_.bgr.at<cv::Vec3b>(100, 160)[1], 0.7 * before + 0.3 * 255, 2);
}

TEST_F(OverlayTest, PathBeforeTheSphereIsWhole) {
  DrawPolylines({{{-1, 4, 0}, {1, 4, 0}}}, {.color = {0, 1, 0}, .width_px = 3}, &picture_);
  for (int x = 90; x < 230; ++x) {
    ASSERT_EQ(picture_.bgr.at<cv::Vec3b>(100, x), cv::Vec3b(0, 255, 0)) << x;
  }
}

TEST_F(OverlayTest, CrossingLinesAreNotDrawnTwice) {
  const StrokeStyle style{.color = {0, 1, 0}, .width_px = 5, .opacity = 0.5};
  DrawPolylines({{{-1, 4, 0}, {1, 4, 0}}, {{0, 4, -0.5}, {0, 4, 0.5}}}, style, &picture_);
  const double before = before_.at<cv::Vec3b>(100, 160)[1];
  EXPECT_NEAR(picture_.bgr.at<cv::Vec3b>(100, 160)[1], 0.5 * before + 127.5, 2);
}

TEST_F(OverlayTest, LinesThroughTheEyeAndOutsideAreHarmless) {
  DrawPolylines({{{0, -5, 0}, {0, 5, 0.1}},
                 {{-1e6, 3, 0}, {1e6, 3, 0}},
                 {{0, -1, 0}, {0, -2, 0}},
                 {{1, 1, 1}},
                 {}},
                {.color = {0, 1, 0}}, &picture_);
  EXPECT_EQ(picture_.bgr.at<cv::Vec3b>(100, 3), cv::Vec3b(0, 255, 0));  // the endless line
}

TEST_F(OverlayTest, FrustumOpensWhereTheCameraLooks) {
  const PinholeCamera camera{640, 480, 500, 500, 320, 240};
  const Rigid3d cam_from_world = CamFromWorld({1, 2, 3}, {DegToRad(90), 0});
  const auto lines = FrustumLines(camera, cam_from_world, 2);
  for (const Eigen::Vector3d& corner : lines.front()) {
    EXPECT_NEAR(corner.x(), 3, 1e-9);  // 2 m to the east
    EXPECT_NEAR(std::abs(corner.y() - 2), 2 * 320.0 / 500, 1e-9);
    EXPECT_NEAR(std::abs(corner.z() - 3), 2 * 240.0 / 500, 1e-9);
  }
  EXPECT_GT(lines.back()[1].z(), 3 + 2 * 240.0 / 500);  // the mark is on top
}

TEST_F(OverlayTest, FilledPolygonIsHiddenToo) {
  FillPolygon({{-2, 8, -0.2}, {2, 8, -0.2}, {2, 8, 0.2}, {-2, 8, 0.2}}, {0, 1, 0}, 1, &picture_);
  EXPECT_EQ(picture_.bgr.at<cv::Vec3b>(100, 90), cv::Vec3b(0, 255, 0));
  EXPECT_EQ(Change(picture_.bgr, before_, 100, 160), 0);
}

TEST_F(OverlayTest, DiscsCoverTheirAreaAndHideEachOther) {
  Picture empty = RenderMesh({}, ConstantColor({1, 1, 1}), LookingNorth(kPictureSize));
  const cv::Mat background = empty.bgr.clone();
  DrawDiscs({{0, 4, 0}, {0, 8, 0}}, {{0, -1, 0}, {0, -1, 0}}, {{0, 0, 1}, {1, 0, 0}}, 0.5, &empty);
  int blue = 0;
  for (int y = 0; y < kPictureSize.height; ++y) {
    for (int x = 0; x < kPictureSize.width; ++x) {
      const cv::Vec3b color = empty.bgr.at<cv::Vec3b>(y, x);
      if (Change(empty.bgr, background, y, x) == 0) continue;
      EXPECT_EQ(color[2], 0);  // the red one, behind, is nowhere seen
      ++blue;
    }
  }
  EXPECT_NEAR(blue, M_PI * 40 * 40, 100);  // 0.5 m at 4 m, focal length 320 px
  EXPECT_NEAR(empty.depth_m.at<float>(100, 160), 4, 1e-5);

  DrawDiscs({{0, 8, 0}}, {{0, -1, 0}}, {{0, 1, 0}}, 0.5, &picture_);
  EXPECT_EQ(Change(picture_.bgr, before_, 100, 160), 0);  // behind the sphere
}

TEST(DrawText, IsCenteredAndOfTheHeightAskedFor) {
  cv::Mat bgr(100, 300, CV_8UC3, cv::Scalar::all(255));
  DrawText("HIH", {150, 50}, 40, {0, 0, 0}, TextAnchor::kCenter, 0, &bgr);
  Eigen::AlignedBox2d ink;
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      if (bgr.at<cv::Vec3b>(y, x)[0] < 128) ink.extend(Eigen::Vector2d(x + 0.5, y + 0.5));
    }
  }
  ASSERT_FALSE(ink.isEmpty());
  EXPECT_NEAR(ink.center().x(), 150, 4);
  EXPECT_NEAR(ink.center().y(), 50, 3);
  EXPECT_NEAR(ink.sizes().y(), 40, 7);
  EXPECT_NEAR(ink.sizes().x(), TextWidth("HIH", 40), 14);
}

TEST(DrawText, OutsideThePictureAndNotAscii) {
  cv::Mat bgr(20, 20, CV_8UC3, cv::Scalar::all(255));
  DrawText("far away", {-500, 900}, 12, {0, 0, 0}, TextAnchor::kLeft, 2, &bgr);
  EXPECT_EQ(cv::countNonZero(bgr.reshape(1) != 255), 0);
  DrawText("\xc3\xa4\n", {2, 10}, 12, {0, 0, 0}, TextAnchor::kLeft, 2, &bgr);
  EXPECT_GT(cv::countNonZero(bgr.reshape(1) != 255), 0);
}

TEST(DrawLegend, ShowsItsColours) {
  cv::Mat bgr(800, 1280, CV_8UC3, cv::Scalar::all(0));
  DrawLegend("Title", {{{1, 0, 0}, "red", "1", false}, {{0, 1, 0}, "green", "22", true}}, &bgr);
  cv::Mat red, green, upper_half = bgr(cv::Rect(0, 0, 1280, 400));
  cv::inRange(bgr, cv::Scalar(0, 0, 255), cv::Scalar(0, 0, 255), red);
  cv::inRange(bgr, cv::Scalar(0, 255, 0), cv::Scalar(0, 255, 0), green);
  EXPECT_GT(cv::countNonZero(red), 100);
  EXPECT_GT(cv::countNonZero(green), 20);
  EXPECT_LT(cv::countNonZero(green), cv::countNonZero(red));  // a line, not a square
  EXPECT_EQ(cv::countNonZero(upper_half.reshape(1)), 0);      // lower left corner only
}

}  // namespace
}  // namespace colmap_ext
