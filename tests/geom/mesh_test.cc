#include "colmap_ext/geom/mesh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// The rectangle [0, width] x [0, height] in z = 0, facing up, and a degenerate face.
TriangleMesh Rectangle(double width, double height) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {width, 0, 0}, {width, height, 0}, {0, height, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 0, 1}};
  return mesh;
}

TEST(Mesh, AreasNormalsBounds) {
  const TriangleMesh mesh = Rectangle(4, 3);
  EXPECT_DOUBLE_EQ(FaceArea(mesh, 0) + FaceArea(mesh, 1), 12.0);
  EXPECT_TRUE(FaceNormal(mesh, 0).isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(FaceNormal(mesh, 2), Eigen::Vector3d::Zero());
  EXPECT_EQ(BoundsOf(mesh).max(), Eigen::Vector3d(4, 3, 0));
  for (const Eigen::Vector3d& normal : VertexNormals(mesh)) {
    EXPECT_TRUE(normal.isApprox(Eigen::Vector3d::UnitZ()));
  }
}

TEST(Mesh, UniformSamplesAreSpreadByArea) {
  const std::vector<SurfaceSample> samples = SampleUniformly(Rectangle(4, 3), 12000, 1);
  ASSERT_EQ(samples.size(), 12000U);
  std::size_t in_quarter = 0;
  for (const SurfaceSample& sample : samples) {
    EXPECT_NE(sample.face, 2);
    in_quarter += sample.position.x() < 2 && sample.position.y() < 1.5 ? 1U : 0U;
  }
  EXPECT_NEAR(static_cast<double>(in_quarter), 3000.0, 200.0);
}

TEST(Mesh, PoissonDisksKeepTheirDistanceAndLeaveNoGap) {
  const TriangleMesh mesh = Rectangle(4, 3);
  const double radius = 0.2;
  const std::vector<SurfaceSample> samples = SamplePoissonDisk(mesh, radius, 5);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t j = i + 1; j < samples.size(); ++j) {
      ASSERT_GE((samples[i].position - samples[j].position).norm(), radius);
    }
  }
  for (const SurfaceSample& probe : SampleUniformly(mesh, 2000, 9)) {
    double nearest = 1e9;
    for (const SurfaceSample& sample : samples) {
      nearest = std::min(nearest, (sample.position - probe.position).norm());
    }
    EXPECT_LT(nearest, 2 * radius);
  }
}

TEST(Mesh, PoissonDisksObeySeedAndMask) {
  const TriangleMesh mesh = Rectangle(4, 3);
  const auto first = SamplePoissonDisk(mesh, 0.3, 5);
  const auto again = SamplePoissonDisk(mesh, 0.3, 5);
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].position, again[i].position);
  for (const SurfaceSample& sample : SamplePoissonDisk(mesh, 0.3, 5, {false, true, false})) {
    EXPECT_EQ(sample.face, 1);
  }
  EXPECT_THROW(SamplePoissonDisk(mesh, 0.0, 5), Error);
  EXPECT_TRUE(SamplePoissonDisk(TriangleMesh(), 0.3, 5).empty());
}

TEST(RayScene, HitsWhereExpected) {
  const RayScene scene(Rectangle(4, 3));
  const auto hit = scene.Intersect({1, 1, 5}, {0, 0, -1}, 0, 100);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->distance_m, 5.0, 1e-5);
  EXPECT_FALSE(scene.Intersect({5, 1, 5}, {0, 0, -1}, 0, 100).has_value());
  EXPECT_FALSE(scene.Intersect({1, 1, 5}, {0, 0, -1}, 0, 4.9).has_value());
}

TEST(RayScene, OcclusionIgnoresItsEnds) {
  const RayScene scene(Rectangle(4, 3));
  EXPECT_TRUE(scene.IsOccluded({1, 1, 1}, {1, 1, -1}, 0.01));
  EXPECT_FALSE(scene.IsOccluded({1, 1, 1}, {1, 1, 0}, 0.01)) << "the end lies on the surface";
  EXPECT_FALSE(scene.IsOccluded({1, 1, 1}, {2, 2, 1}, 0.01));
}

TEST(RayScene, DistanceAgreesWithBruteForce) {
  const RayScene scene(Rectangle(4, 3));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-3, 7);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d point(uniform(random), uniform(random), uniform(random));
    const Eigen::Vector3d nearest(std::clamp(point.x(), 0.0, 4.0), std::clamp(point.y(), 0.0, 3.0),
                                  0.0);
    EXPECT_NEAR(scene.DistanceToSurface(point, 100), (point - nearest).norm(), 1e-5);
  }
  EXPECT_DOUBLE_EQ(scene.DistanceToSurface({1, 1, 50}, 10), 10.0);
}

TEST(RayScene, EmptyMeshIsNeverHit) {
  const RayScene scene{TriangleMesh()};
  EXPECT_FALSE(scene.Intersect({0, 0, 1}, {0, 0, -1}, 0, 100).has_value());
  EXPECT_FALSE(scene.IsOccluded({0, 0, 1}, {0, 0, -1}, 0.01));
  EXPECT_EQ(scene.DistanceToSurface({0, 0, 0}, 7), 7);
}

TEST(RayScene, LeavesTheThreadsOfTheProcessAlone) {
  const auto threads = [] {
    return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  };
  const std::size_t before = threads();
  const RayScene scene(Rectangle(4, 3));
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace colmap_ext
