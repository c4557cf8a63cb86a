#include "colmap_ext/geom/closest_point.h"

#include <gtest/gtest.h>

#include <random>

namespace colmap_ext {
namespace {

Eigen::Vector3d RandomPoint(std::mt19937_64* random, double range) {
  std::uniform_real_distribution<double> uniform(-range, range);
  const double x = uniform(*random), y = uniform(*random), z = uniform(*random);
  return {x, y, z};
}

TEST(ClosestPointOnTriangle, KnownRegions) {
  const Eigen::Vector3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  EXPECT_EQ(ClosestPointOnTriangle({0.5, 0.5, 3}, a, b, c), Eigen::Vector3d(0.5, 0.5, 0));
  EXPECT_EQ(ClosestPointOnTriangle({-1, -1, 1}, a, b, c), a);
  EXPECT_EQ(ClosestPointOnTriangle({1, -1, 0}, a, b, c), Eigen::Vector3d(1, 0, 0));
  EXPECT_LT((ClosestPointOnTriangle({2, 2, 0}, a, b, c) - Eigen::Vector3d(1, 1, 0)).norm(), 1e-15);
  // A triangle without area is a segment.
  EXPECT_EQ(ClosestPointOnTriangle({0.5, 1, 0}, a, b, b), Eigen::Vector3d(0.5, 0, 0));
}

TEST(ClosestPointIndex, AgreesWithExhaustiveSearch) {
  std::mt19937_64 random(7);
  TriangleMesh mesh;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d anchor = RandomPoint(&random, 5);
    const int first = static_cast<int>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(anchor + RandomPoint(&random, 1));
    mesh.faces.emplace_back(first, first + 1, first + 2);
  }
  const ClosestPointIndex surface(mesh);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d query = RandomPoint(&random, 8);
    double nearest_surface = 1e30;
    for (const Eigen::Vector3i& face : mesh.faces) {
      const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(face[k])]; };
      const Eigen::Vector3d closest =
          ClosestPointOnTriangle(query, corner(0), corner(1), corner(2));
      nearest_surface = std::min(nearest_surface, (closest - query).norm());
    }
    const auto on_surface = surface.Find(query);
    ASSERT_TRUE(on_surface);
    EXPECT_NEAR(on_surface->distance, nearest_surface, 1e-12);
    EXPECT_NEAR((on_surface->position - query).norm(), nearest_surface, 1e-12);
    EXPECT_FALSE(surface.Find(query, 0.999 * nearest_surface));
    EXPECT_TRUE(surface.Find(query, 1.001 * nearest_surface));
  }
}

TEST(ClosestPointIndex, NothingInNothing) {
  EXPECT_FALSE(ClosestPointIndex(TriangleMesh()).Find({0, 0, 0}));
  TriangleMesh cloud;
  cloud.vertices.emplace_back(1, 2, 3);
  EXPECT_FALSE(ClosestPointIndex(cloud).Find({0, 0, 0}));
}

}  // namespace
}  // namespace colmap_ext
