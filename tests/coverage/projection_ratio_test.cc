#include "colmap_ext/coverage/projection_ratio.h"

#include <gtest/gtest.h>

#include <random>

#include "coverage/test_scene.h"

namespace colmap_ext {
namespace {

// Area in the image of a polygon of 200 corners on the disk, by the shoelace formula.
double ProjectedArea(const PosedPhoto& photo, const Eigen::Vector3d& center,
                     const Eigen::Vector3d& normal, double radius) {
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  constexpr int kCorners = 200;
  std::vector<Eigen::Vector2d> pixels;
  for (int i = 0; i < kCorners; ++i) {
    const double t = 2 * std::numbers::pi * i / kCorners;
    pixels.push_back(photo.camera.Project(photo.cam_from_world *
                                          (center + radius * (std::cos(t) * u + std::sin(t) * v))));
  }
  double twice = 0;
  for (int i = 0; i < kCorners; ++i) {
    const Eigen::Vector2d a = pixels[static_cast<std::size_t>(i)] - pixels[0];
    const Eigen::Vector2d b = pixels[static_cast<std::size_t>((i + 1) % kCorners)] - pixels[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  const double polygon_area =
      0.5 * kCorners * std::sin(2 * std::numbers::pi / kCorners) * radius * radius;
  return 0.5 * std::abs(twice) / polygon_area;
}

TEST(ProjectionRatio, EqualsTheProjectedAreaOfASmallDisk) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int tested = 0;
  while (tested < 200) {
    PosedPhoto photo =
        PhotoAt({unit(random), unit(random), unit(random)}, 180 * unit(random), 80 * unit(random));
    photo.camera.fx = 400;
    photo.camera.fy = 510;
    const Eigen::Vector3d point_in_cam(4 * unit(random), 2 * unit(random), 6 + 4 * unit(random));
    const Eigen::Vector3d point = Inverse(photo.cam_from_world) * point_in_cam;
    const Eigen::Vector3d normal =
        Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
    const double ratio = ProjectionRatio(photo.camera, photo.cam_from_world, point, normal);
    const double projected = ProjectedArea(photo, point, normal, 1e-3);
    const bool is_facing = normal.dot(CameraCenter(photo.cam_from_world) - point) > 0;
    if (!is_facing) {
      EXPECT_EQ(ratio, 0);
      continue;
    }
    EXPECT_NEAR(ratio / projected, 1.0, 1e-4);
    ++tested;
  }
}

TEST(ProjectionRatio, OnTheAxisItIsFocalLengthsOverSquaredDistanceTimesCosine) {
  const PosedPhoto photo = PhotoAt({0, -10, 0}, 0);
  const Eigen::Vector3d normal(std::sin(0.7), -std::cos(0.7), 0);
  EXPECT_NEAR(ProjectionRatio(photo.camera, photo.cam_from_world, {0, 0, 0}, normal),
              467.0 * 467.0 * std::cos(0.7) / 100.0, 1e-6);
}

TEST(ProjectionRatio, IsZeroBehindTheCameraAndFromBehindTheSurface) {
  const PosedPhoto photo = PhotoAt({0, -10, 0}, 0);
  EXPECT_EQ(ProjectionRatio(photo.camera, photo.cam_from_world, {0, -12, 0}, {0, 1, 0}), 0);
  EXPECT_EQ(ProjectionRatio(photo.camera, photo.cam_from_world, {0, -10, 0}, {0, -1, 0}), 0);
  EXPECT_EQ(ProjectionRatio(photo.camera, photo.cam_from_world, {0, 0, 0}, {0, 1, 0}), 0);
}

TEST(ProjectionRatio, GroundSamplingDistanceIsItsInverseSquareRoot) {
  // 467 px focal length at 18.68 m: a pixel covers 40 mm.
  const PosedPhoto photo = PhotoAt({0, -18.68, 0}, 0);
  EXPECT_NEAR(ProjectionRatio(photo.camera, photo.cam_from_world, {0, 0, 0}, {0, -1, 0}),
              ProjectionRatioOfGroundSamplingDistance(40), 1e-6);
}

}  // namespace
}  // namespace colmap_ext
