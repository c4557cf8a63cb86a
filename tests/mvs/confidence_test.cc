#include "colmap_ext/mvs/confidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "colmap_ext/mvs/superpixels.h"
#include "mvs/analytic_scene.h"

namespace colmap_ext {
namespace {

using test::LookAt;
using test::TestCamera;

// A view of the plane z = 0 whose mesh has the depths of the plane z = height.
ViewMesh PlaneView(const Rigid3d& cam_from_world, double height) {
  ViewMesh view;
  view.camera = TestCamera();
  view.cam_from_world = cam_from_world;
  SuperpixelOptions options;
  options.target_polygons = 400;
  view.image = SegmentPhoto(cv::Mat(240, 320, CV_8UC3, cv::Scalar(90, 90, 90)), options);
  const Eigen::Vector3d center = CameraCenter(cam_from_world);
  for (const Eigen::Vector3i& corners : view.image.triangles) {
    Eigen::Vector3d depth;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d ray =
          cam_from_world.rotation.conjugate() *
          view.camera.Ray(view.image.vertices_px[static_cast<std::size_t>(corners[k])]);
      depth[k] = ray.z() / (height - center.z());
    }
    view.inverse_depth.push_back(depth);
  }
  view.confidence.assign(view.image.triangles.size(), 0.0F);
  view.supported.assign(view.image.triangles.size(), 1);
  return view;
}

struct TwoViews {
  TwoViews(double height_0, double height_1, const Rigid3d& pose_1 = LookAt({2, -3, 10}, {0, 0, 0}))
      : views{PlaneView(LookAt({0, -3, 10}, {0, 0, 0}), height_0), PlaneView(pose_1, height_1)} {
    for (const ViewMesh& view : views) lookups.emplace_back(view, TriangleIdMap(view));
  }
  ConfidenceCues Center(const std::vector<int>& neighbors) const {
    const auto cues = EvaluateCues(views, lookups, neighbors, 0, {});
    return cues[static_cast<std::size_t>(lookups[0].TriangleAt({160.0, 120.0}))];
  }
  std::vector<ViewMesh> views;
  std::vector<ViewLookup> lookups;
};

TEST(Confidence, IsThePapersEquation) {
  SuperpixelStereoOptions options;
  options.sigma_position_px = 2;
  options.sigma_normal_deg = 30;
  options.sigma_view = 0.2;
  const ConfidenceCues cues{3, 1.5, 0.2, 0.7};
  const double cosine = std::cos(0.7);
  EXPECT_NEAR(
      ConfidenceScore(cues, options),
      std::exp(-1.5 / 2) * std::exp(-0.2 / (M_PI / 6)) * (1 - std::exp(-cosine * cosine / 0.2)),
      1e-12);
  EXPECT_EQ(ConfidenceScore({0, 0, 0, 0}, options), 0);
}

TEST(Confidence, ViewsThatAgreeHaveNoError) {
  const TwoViews scene(0, 0);
  const ConfidenceCues cues = scene.Center({1});
  EXPECT_EQ(cues.witnesses, 1);
  EXPECT_NEAR(cues.position_px, 0, 1e-6);
  EXPECT_NEAR(cues.normal_rad, 0, 1e-6);
  EXPECT_NEAR(cues.view_rad, std::atan2(3, 10), 0.02);
  EXPECT_GT(ConfidenceScore(cues, {}), 0.9);
}

TEST(Confidence, PositionErrorIsTheForwardBackwardReprojection) {
  // The facet floats 0.5 m above the ground that the neighbour has.
  const TwoViews scene(0.5, 0);
  const ConfidenceCues cues = scene.Center({1});
  ASSERT_EQ(cues.witnesses, 1);
  const auto t = static_cast<std::size_t>(scene.lookups[0].TriangleAt({160.0, 120.0}));
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (int k = 0; k < 3; ++k) {
    centroid +=
        scene.views[0]
            .image.vertices_px[static_cast<std::size_t>(scene.views[0].image.triangles[t][k])] /
        3;
  }
  const Eigen::Vector3d point = scene.lookups[0].PointInWorld(static_cast<int>(t), centroid);
  const Eigen::Vector3d eye = CameraCenter(scene.views[1].cam_from_world);
  const Eigen::Vector3d on_ground = eye + (point - eye) * (eye.z() / (eye.z() - point.z()));
  const Eigen::Vector2d back = TestCamera().Project(scene.views[0].cam_from_world * on_ground);
  EXPECT_NEAR(cues.position_px, (back - centroid).norm(), 1e-6);
  EXPECT_GT(cues.position_px, 2.0);
}

TEST(Confidence, ANeighbourThatIsOccludedIsNoWitness) {
  const TwoViews scene(0, 2);  // the neighbour sees something 2 m above the facet
  EXPECT_EQ(scene.Center({1}).witnesses, 0);
}

TEST(Confidence, WithoutWitnessThereIsNone) {
  TwoViews scene(0, 0);
  EXPECT_EQ(scene.Center({}).witnesses, 0);
  scene.views[1].supported.assign(scene.views[1].supported.size(), 0);
  EXPECT_EQ(scene.Center({1}).witnesses, 0);
  EvaluateConfidence(scene.lookups, {{1}, {0}}, {0, 1}, {}, &scene.views);
  for (const float confidence : scene.views[0].confidence) EXPECT_EQ(confidence, 0.0F);
}

TEST(Confidence, FacetsOutsideTheNeighboursImageHaveNoWitness) {
  TwoViews scene(0, 0, LookAt({4, -3, 10}, {4, 0, 0}));
  EvaluateConfidence(scene.lookups, {{1}, {0}}, {0, 1}, {}, &scene.views);
  const auto left = static_cast<std::size_t>(scene.lookups[0].TriangleAt({3.0, 120.0}));
  const auto right = static_cast<std::size_t>(scene.lookups[0].TriangleAt({300.0, 120.0}));
  EXPECT_EQ(scene.views[0].confidence[left], 0.0F);
  EXPECT_GT(scene.views[0].confidence[right], 0.5F);
}

TEST(ViewLookup, PlanesAndNormalsAreThoseOfTheMesh) {
  const TwoViews scene(0, 0);
  const ViewLookup& lookup = scene.lookups[0];
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(20, 30), Eigen::Vector2d(200.5, 111.25)}) {
    const int t = lookup.TriangleAt(pixel);
    ASSERT_GE(t, 0);
    EXPECT_NEAR(lookup.PointInWorld(t, pixel).z(), 0, 1e-9);
    EXPECT_NEAR(
        (lookup.normal_in_world[static_cast<std::size_t>(t)] - Eigen::Vector3d::UnitZ()).norm(), 0,
        1e-9);
  }
  EXPECT_EQ(lookup.TriangleAt({-0.1, 10}), -1);
  EXPECT_EQ(lookup.TriangleAt({320.0, 10}), -1);
}

TEST(Confidence, CueMapsHoldTheFactorsOfTheScore) {
  const SuperpixelStereoOptions options;
  const std::vector<ConfidenceCues> cues{{2, 1.0, 0.3, 0.5}, {0, 0, 0, 0}};
  const cv::Mat1i triangle_at = (cv::Mat1i(1, 3) << 0, 1, -1);
  const DenseMap maps = ConfidenceCueMaps(cues, triangle_at, options);
  ASSERT_EQ(maps.channels, 4);
  EXPECT_NEAR(maps.At(0, 0, 0), std::exp(-1.0 / options.sigma_position_px), 1e-6);
  EXPECT_NEAR(maps.At(0, 0, 0) * maps.At(0, 0, 1) * maps.At(0, 0, 2), maps.At(0, 0, 3), 1e-6);
  EXPECT_NEAR(maps.At(0, 0, 3), ConfidenceScore(cues[0], options), 1e-6);
  for (int c = 0; c < 4; ++c) {
    EXPECT_EQ(maps.At(0, 1, c), 0);
    EXPECT_EQ(maps.At(0, 2, c), 0);
  }
}

}  // namespace
}  // namespace colmap_ext
