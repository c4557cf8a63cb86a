#include "colmap_ext/coverage/visibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "colmap_ext/util/error.h"
#include "coverage/test_scene.h"

namespace colmap_ext {
namespace {

bool Sees(const VisibilityEngine& engine, const PosedPhoto& photo, const Eigen::Vector3d& point,
          const Eigen::Vector3d& normal) {
  return engine.IsVisible(photo.camera, photo.cam_from_world, point, normal);
}

TEST(VisibilityEngine, OfABallTheSideThatFacesTheCameraIsSeen) {
  const TriangleMesh ball = Ball({0, 0, 0}, 1, 60);
  VisibilityOptions options;
  options.max_incidence_deg = 75;
  const VisibilityEngine engine(ball, options);
  const PosedPhoto photo = PhotoAt({0, -4, 0}, 0);
  int seen = 0;
  for (const SurfaceSample& sample : SampleUniformly(ball, 2000, 1)) {
    const Eigen::Vector3d to_camera = Eigen::Vector3d(0, -4, 0) - sample.position;
    const double incidence_deg = RadToDeg(std::acos(sample.normal.dot(to_camera.normalized())));
    if (std::abs(incidence_deg - 75) < 1e-6) continue;
    EXPECT_EQ(Sees(engine, photo, sample.position, sample.normal), incidence_deg < 75)
        << sample.position.transpose();
    seen += incidence_deg < 75 ? 1 : 0;
  }
  EXPECT_GT(seen, 300);
}

TEST(VisibilityEngine, APanelHidesWhatIsExactlyBehindIt) {
  TriangleMesh mesh = Wall().mesh;
  AppendPanel({-1, -5, 2}, {2, 0, 0}, {0, 0, 2}, 4, &mesh);
  const VisibilityEngine engine(mesh, VisibilityOptions());
  // From (0, -10, 3) the panel, half way, throws a shadow of twice its size: |x| < 2, |z - 3| < 2.
  const PosedPhoto photo = PhotoAt({0, -10, 3}, 0);
  for (double x = -4.9; x < 5; x += 0.2) {
    const bool is_shadowed = std::abs(x) < 2;
    EXPECT_EQ(Sees(engine, photo, {x, 0, 3}, {0, -1, 0}), !is_shadowed) << x;
  }
}

TEST(VisibilityEngine, TheImageEndsTheView) {
  const VisibilityEngine engine(Wall().mesh, VisibilityOptions());
  const PosedPhoto photo = PhotoAt({0, -5, 3}, 0);
  // 316 px (320 less the border of 4) are 316 / 467 * 5 m = 3.383 m.
  EXPECT_TRUE(Sees(engine, photo, {3.38, 0, 3}, {0, -1, 0}));
  EXPECT_FALSE(Sees(engine, photo, {3.39, 0, 3}, {0, -1, 0}));
  EXPECT_FALSE(Sees(engine, PhotoAt({0, -5, 3}, 180), {0, 0, 3}, {0, -1, 0}));
}

TEST(VisibilityEngine, RoughnessBelowEpsilonHidesNothing) {
  TriangleMesh mesh = Wall().mesh;
  AppendPanel({-5, -0.03, 0}, {10, 0, 0}, {0, 0, 6}, 4, &mesh);  // a skin 3 cm in front
  VisibilityOptions options;
  options.epsilon_m = 0.05;
  const PosedPhoto photo = PhotoAt({0, -8, 3}, 0);
  EXPECT_TRUE(Sees(VisibilityEngine(mesh, options), photo, {1, 0, 3}, {0, -1, 0}));
  options.epsilon_m = 0.01;
  EXPECT_FALSE(Sees(VisibilityEngine(mesh, options), photo, {1, 0, 3}, {0, -1, 0}));
}

TEST(VisibilityEngine, AutomaticEpsilonFollowsTheMesh) {
  const TriangleMesh wall = Wall().mesh;  // edges of 0.15, 0.25 and 0.29 m, diagonal 11.7 m
  EXPECT_NEAR(VisibilityEngine(wall, VisibilityOptions()).epsilon_m(), 0.002 * std::sqrt(136.0),
              1e-9);
  EXPECT_EQ(VisibilityEngine(TriangleMesh(), VisibilityOptions()).epsilon_m(), 0);
}

TEST(VisibilityEngine, NothingHidesWithoutAMesh) {
  const VisibilityEngine engine(TriangleMesh{}, VisibilityOptions{});
  EXPECT_TRUE(Sees(engine, PhotoAt({0, -5, 3}, 0), {0, 0, 3}, {0, -1, 0}));
  EXPECT_EQ(engine.ray_scene().NumFaces(), 0U);
}

TEST(VisibilityOptions, WrongValuesAreNamed) {
  VisibilityOptions options;
  EXPECT_EQ(options.Check(), "");
  options.max_incidence_deg = 0;
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("max_incidence_deg"));
  EXPECT_THROW(VisibilityEngine(TriangleMesh(), options), UsageError);
  options = {};
  options.epsilon_m = -0.1;
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("epsilon_m"));
}

}  // namespace
}  // namespace colmap_ext
