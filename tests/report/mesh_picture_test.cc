#include "colmap_ext/report/mesh_picture.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/util/error.h"
#include "report/analytic_scene.h"

namespace colmap_ext {
namespace {

const cv::Size kSize(320, 200);

cv::Vec3b BackgroundAt(int y) {
  const Picture empty = RenderMesh({}, ConstantColor({1, 0, 0}), LookingNorth(kSize));
  return empty.bgr.at<cv::Vec3b>(y, 0);
}

TEST(RenderMesh, SphereBeforeAPlaneHasKnownColoursAndDepths) {
  const SphereAndWall scene;
  const Picture picture =
      RenderMesh(scene.mesh, FaceColors(scene.face_colors), LookingNorth(kSize));
  ASSERT_EQ(picture.bgr.size(), kSize);
  ASSERT_EQ(picture.bgr.type(), CV_8UC3);
  // The middle shows the sphere (red), its border the wall (blue), the corner the background.
  const cv::Vec3b middle = picture.bgr.at<cv::Vec3b>(100, 160);
  EXPECT_GT(middle[2], 2 * middle[0] + 20);
  EXPECT_NEAR(picture.depth_m.at<float>(100, 160), SphereAndWall::kSphereDistance - 1, 0.01);
  const cv::Vec3b wall = picture.bgr.at<cv::Vec3b>(100, 250);
  EXPECT_GT(wall[0], 2 * wall[2] + 20);
  EXPECT_NEAR(picture.depth_m.at<float>(100, 250), SphereAndWall::kWallDistance, 1e-4);
  EXPECT_EQ(picture.bgr.at<cv::Vec3b>(2, 2), BackgroundAt(2));
  EXPECT_TRUE(std::isinf(picture.depth_m.at<float>(2, 2)));
}

TEST(RenderMesh, SilhouetteIsWhereItShouldBeAndSmooth) {
  const SphereAndWall scene;
  const PictureCamera camera = LookingNorth(kSize);
  const Picture picture = RenderMesh(scene.mesh, FaceColors(scene.face_colors), camera);
  // The sphere's outline: half angle asin(1 / distance).
  const double radius_px =
      camera.camera.fx * std::tan(std::asin(1.0 / SphereAndWall::kSphereDistance));
  int red = 0, mixed = 0;
  for (int x = 40; x < 280; ++x) {  // the wall's part of the row
    const cv::Vec3b color = picture.bgr.at<cv::Vec3b>(100, x);
    if (color[2] > 2 * color[0]) ++red;
    if (color[2] <= 2 * color[0] && color[0] <= 2 * color[2]) ++mixed;
  }
  EXPECT_NEAR(red, 2 * radius_px, 2.5);
  EXPECT_LE(mixed, 4);
}

TEST(RenderMesh, TheSunComesFromTheLeft) {
  const SphereAndWall scene;
  const Picture picture =
      RenderMesh(scene.mesh, FaceColors(scene.face_colors), LookingNorth(kSize));
  EXPECT_GT(picture.bgr.at<cv::Vec3b>(90, 145)[2], picture.bgr.at<cv::Vec3b>(110, 175)[2] + 20);
}

TEST(RenderMesh, ShadowFallsOnTheFloorToTheRight) {
  SphereAndWall scene;
  const int first = static_cast<int>(scene.mesh.vertices.size());
  for (const auto& [x, y] : {std::pair{-9.0, 1.0}, {9.0, 1.0}, {9.0, 9.0}, {-9.0, 9.0}}) {
    scene.mesh.vertices.emplace_back(x, y, -1.4);
  }
  scene.mesh.faces.emplace_back(first, first + 1, first + 2);
  scene.mesh.faces.emplace_back(first, first + 2, first + 3);
  scene.face_colors.resize(scene.mesh.faces.size(), Rgb(0.1f, 0.1f, 0.9f));
  PictureOptions without;
  without.shadows = false;
  const PictureCamera camera = LookingNorth(kSize);
  const Picture lit = RenderMesh(scene.mesh, FaceColors(scene.face_colors), camera, without);
  const Picture shadowed = RenderMesh(scene.mesh, FaceColors(scene.face_colors), camera);
  int darker_left = 0, darker_right = 0;
  for (int y = 101; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const int change = lit.bgr.at<cv::Vec3b>(y, x)[0] - shadowed.bgr.at<cv::Vec3b>(y, x)[0];
      EXPECT_GE(change, -1);
      if (change > 15) ++(x < 160 ? darker_left : darker_right);
    }
  }
  EXPECT_GT(darker_right, 300);
  EXPECT_GT(darker_right, 4 * darker_left);
}

TEST(RenderMesh, SameResultTwice) {
  const SphereAndWall scene;
  const MeshPainter painter(scene.mesh);
  const Picture a = painter.Render(FaceColors(scene.face_colors), LookingNorth(kSize));
  const Picture b = painter.Render(FaceColors(scene.face_colors), LookingNorth(kSize));
  EXPECT_EQ(cv::norm(a.bgr, b.bgr, cv::NORM_INF), 0);
}

TEST(VertexColors, AreInterpolatedAndCounted) {
  TriangleMesh mesh;
  mesh.vertices = {{-4, 10, -4}, {4, 10, -4}, {4, 10, 4}, {-4, 10, 4}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  const std::vector<Eigen::Vector3d> colors = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  const Picture picture = RenderMesh(mesh, VertexColors(mesh, colors), LookingNorth(kSize));
  int before = -1;
  for (int x = 90; x < 230; x += 20) {
    const cv::Vec3b color = picture.bgr.at<cv::Vec3b>(100, x);
    EXPECT_GT(color[2], before);
    EXPECT_EQ(color[0], 0);
    before = color[2];
  }
  EXPECT_THROW(VertexColors(mesh, {{0, 0, 0}}), Error);
}

TEST(FitCamera, ShowsEverythingAsLargeAsPossible) {
  const BoundingBox box(Eigen::Vector3d(-3, 10, 0), Eigen::Vector3d(20, 14, 9));
  for (const double yaw : {0.0, 0.7, 2.5, -1.9}) {
    for (const double pitch : {0.0, -0.6, -1.5}) {
      const PictureCamera camera = FitCamera(box, {yaw, pitch}, {800, 500}, 0.1);
      Eigen::AlignedBox2d pixels;
      for (const Eigen::Vector3d& corner : CornersOf(box)) {
        const Eigen::Vector3d in_cam = camera.cam_from_world * corner;
        ASSERT_GT(in_cam.z(), 0);
        pixels.extend(camera.camera.Project(in_cam));
      }
      EXPECT_GE(pixels.min().x(), 80 - 1e-6);
      EXPECT_LE(pixels.max().x(), 720 + 1e-6);
      EXPECT_GE(pixels.min().y(), 50 - 1e-6);
      EXPECT_LE(pixels.max().y(), 450 + 1e-6);
      const bool fills_width = pixels.sizes().x() > 639.9,
                 fills_height = pixels.sizes().y() > 399.9;
      EXPECT_TRUE(fills_width || fills_height) << yaw << " " << pitch;
      const ViewDirection seen = ViewDirectionOf(camera.cam_from_world);
      EXPECT_NEAR(seen.pitch_rad, pitch, 1e-9);
    }
  }
}

TEST(FitCamera, SinglePointAndNoPoint) {
  const PictureCamera camera =
      FitCamera(std::vector<Eigen::Vector3d>{{5, 6, 7}}, {0.3, -0.4}, {100, 100});
  const Eigen::Vector3d in_cam = camera.cam_from_world * Eigen::Vector3d(5, 6, 7);
  EXPECT_GT(in_cam.z(), 0);
  EXPECT_LT((camera.camera.Project(in_cam) - Eigen::Vector2d(50, 50)).norm(), 1e-6);
  EXPECT_THROW(FitCamera(BoundingBox(), {0, 0}, {100, 100}), Error);
}

TEST(RobustBounds, FarPointsDoNotCount) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 1000; ++i) points.emplace_back(0.01 * i, 5 - 0.01 * i, 0);
  points.emplace_back(1e6, -1e6, 1e6);
  const BoundingBox box = RobustBounds(points, 0.01);
  EXPECT_NEAR(box.min().x(), 0.1, 0.011);
  EXPECT_NEAR(box.max().x(), 9.9, 0.02);
  EXPECT_EQ(box.max().z(), 0);
  EXPECT_TRUE(RobustBounds({}, 0.01).isEmpty());
}

TEST(WritePng, RoundTripAndErrors) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "mesh_picture_test.png";
  const cv::Mat picture(5, 7, CV_8UC3, cv::Scalar(10, 20, 30));
  WritePng(picture, path);
  EXPECT_EQ(cv::norm(cv::imread(path.string()), picture, cv::NORM_INF), 0);
  EXPECT_THROW(WritePng(cv::Mat(), path), Error);
  EXPECT_THROW(WritePng(picture, path / "below_a_file.png"), Error);
}

}  // namespace
}  // namespace colmap_ext
