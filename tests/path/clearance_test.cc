#include "colmap_ext/path/clearance.h"

#include <gtest/gtest.h>

#include <random>

#include "path/box_world.h"

namespace colmap_ext {
namespace {

// A wire of 3 cm along y, at x = 5.5, z = 10.
const std::vector<Eigen::AlignedBox3d> kWire = {
    {Eigen::Vector3d(5.485, -20, 9.985), Eigen::Vector3d(5.515, 20, 10.015)}};

TEST(ProveClearance, RejectsAThinWireBetweenSamplePoints) {
  const RayScene scene(MeshOf(kWire));
  // Cells of 1 m have their centres 0.485 m away from the wire on both sides.
  const Eigen::Vector3d a(5, 0.5, 10), b(6, 0.5, 10);
  EXPECT_GT(scene.DistanceToSurface(a, 10), 0.45);
  EXPECT_GT(scene.DistanceToSurface(b, 10), 0.45);
  EXPECT_FALSE(ProveClearance(scene, a, b, 0.45, 0.01));
  EXPECT_FALSE(ProveClearance(scene, a, b, 0.0, 0.01));
  EXPECT_TRUE(
      ProveClearance(scene, a + Eigen::Vector3d(0, 0, 1), b + Eigen::Vector3d(0, 0, 1), 0.9, 0.01));
}

TEST(ProveClearance, IsSharpWithinTheTolerance) {
  const RayScene scene(MeshOf({{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(10, 10, 5)}}));
  const Eigen::Vector3d a(-5, 5, 8), b(15, 5, 8);  // 3 m above the top
  EXPECT_TRUE(ProveClearance(scene, a, b, 2.98, 0.01));
  EXPECT_FALSE(ProveClearance(scene, a, b, 3.0, 0.01));
  EXPECT_TRUE(ProveClearance(scene, a, a, 2.98, 0.01));
}

TEST(ProveClearance, NeverContradictsADenseSampling) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0, 20), size(0.1, 4);
  int proved = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d low(place(random), place(random), place(random));
      boxes.emplace_back(low, low + Eigen::Vector3d(size(random), size(random), size(random)));
    }
    const RayScene scene(MeshOf(boxes));
    const Eigen::Vector3d a(place(random), place(random), place(random));
    const Eigen::Vector3d b(place(random), place(random), place(random));
    const std::vector<Waypoint> line = {{a, {}, -1}, {b, {}, -1}};
    // The mesh is hollow, a box is not: leave out lines that enter one.
    const double truth = SampledClearance(boxes, line);
    if (truth == 0) continue;
    const double bound = ProvedMinClearance(scene, {a, b}, 0.02, 100);
    EXPECT_LE(bound, truth + 1e-6) << trial;
    EXPECT_GE(bound, truth - 0.03) << trial;
    if (ProveClearance(scene, a, b, 1.0, 0.02)) {
      ++proved;
      EXPECT_GE(truth, 1.0) << trial;
    } else {
      EXPECT_LT(truth, 1.03) << trial;
    }
  }
  EXPECT_GT(proved, 30);
}

TEST(ProvedMinClearance, HandlesEmptyAndSinglePointsAndFarSurfaces) {
  const RayScene scene(MeshOf({{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1)}}));
  EXPECT_EQ(ProvedMinClearance(scene, {}, 0.01, 50), 50);
  EXPECT_NEAR(ProvedMinClearance(scene, {{0.5, 0.5, 4}}, 0.01, 50), 3, 0.012);
  EXPECT_NEAR(ProvedMinClearance(scene, {{500, 0, 0}, {600, 0, 0}}, 0.01, 50), 50, 0.012);
  EXPECT_EQ(ProvedMinClearance(scene, {{0.5, 0.5, -3}, {0.5, 0.5, 3}}, 0.01, 50), 0);
}

}  // namespace
}  // namespace colmap_ext
