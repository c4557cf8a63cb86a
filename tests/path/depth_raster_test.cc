#include "path/depth_raster.h"

#include <gtest/gtest.h>

#include <random>

#include "path/box_world.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kAll = 1000000;  // one cluster: nothing is sorted or left out

struct Ball {
  Eigen::Vector3d center;
  double radius_m;
};

class RandomWorld {
 public:
  explicit RandomWorld(unsigned seed) : random_(seed) {}

  Eigen::Vector3d Point(double half_m) {
    return {Number(-half_m, half_m), Number(-half_m, half_m), Number(-half_m, half_m)};
  }
  double Number(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }

  // A bumpy floor of small faces, and loose triangles of all sizes, some through the camera.
  TriangleMesh Mesh() {
    TriangleMesh mesh;
    constexpr int kSide = 60;
    for (int i = 0; i <= kSide; ++i) {
      for (int j = 0; j <= kSide; ++j) {
        mesh.vertices.emplace_back(0.5 * i - 15, 0.5 * j - 15, Number(-4.3, -4));
        if (i == kSide || j == kSide) continue;
        const int v = i * (kSide + 1) + j;
        mesh.faces.emplace_back(v, v + kSide + 1, v + 1);
        mesh.faces.emplace_back(v + 1, v + kSide + 1, v + kSide + 2);
      }
    }
    for (int i = 0; i < 60; ++i) {
      const int first = static_cast<int>(mesh.vertices.size());
      const Eigen::Vector3d middle = Point(12);
      const double size = Number(0, 1) < 0.8 ? 0.4 : 8;
      for (int k = 0; k < 3; ++k) mesh.vertices.push_back(middle + Point(size));
      mesh.faces.emplace_back(first, first + 1, first + 2);
    }
    return mesh;
  }

 private:
  std::mt19937 random_;
};

Rigid3d PoseAt(RandomWorld* world) {
  return CamFromWorld(world->Point(8), {world->Number(-3, 3), world->Number(-1.4, 0.3)});
}

// The nearest that any corner of a face is to a pyramid of rays is not known here; a ball that was
// seen past must at least be hidden by nothing on the rays through it.
bool SomethingIsBefore(const TriangleMesh& mesh, const Eigen::Vector3d& eye, const Ball& ball,
                       RandomWorld* world) {
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d target = ball.center + ball.radius_m * world->Point(0.57);
    const Eigen::Vector3d ray = target - eye;
    for (const Eigen::Vector3i& face : mesh.faces) {
      const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(face[0])];
      const Eigen::Vector3d u = mesh.vertices[static_cast<std::size_t>(face[1])] - a;
      const Eigen::Vector3d v = mesh.vertices[static_cast<std::size_t>(face[2])] - a;
      Eigen::Matrix3d system;
      system << u, v, -ray;
      if (std::abs(system.determinant()) < 1e-12) continue;
      const Eigen::Vector3d x = system.inverse() * (eye - a);
      if (x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] > 0.02 && x[2] < 1) return true;
    }
  }
  return false;
}

TEST(DepthRaster, IsTheSameHoweverTheFacesAreClustered) {
  int seen = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomWorld world(seed);
    const TriangleMesh mesh = world.Mesh();
    std::vector<bool> confident(mesh.faces.size());
    for (std::size_t f = 0; f < confident.size(); ++f) confident[f] = world.Number(0, 1) < 0.999;
    const PinholeCamera camera{640, 368, 500, 500, 320, 184};
    const Rigid3d pose = PoseAt(&world);
    const DepthRaster plain(FaceClusters(mesh, confident, kAll), pose, camera);
    const DepthRaster clustered(FaceClusters(mesh, confident), pose, camera);
    const DepthRaster single(FaceClusters(mesh, confident, 1), pose, camera);
    for (int i = 0; i < 5000; ++i) {
      const Ball ball{world.Point(15), world.Number(0, 0.3)};
      const bool expected = plain.HasSeenPast(ball.center, ball.radius_m);
      EXPECT_EQ(clustered.HasSeenPast(ball.center, ball.radius_m), expected) << seed;
      EXPECT_EQ(single.HasSeenPast(ball.center, ball.radius_m), expected) << seed;
      seen += expected ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 200);
}

TEST(DepthRaster, SeesPastNothingThatAFaceHides) {
  int seen = 0;
  for (unsigned seed = 100; seed < 106; ++seed) {
    RandomWorld world(seed);
    const TriangleMesh mesh = world.Mesh();
    const Rigid3d pose = PoseAt(&world);
    const DepthRaster raster(FaceClusters(mesh, {}), pose, {640, 368, 500, 500, 320, 184});
    for (int i = 0; i < 1000; ++i) {
      const Ball ball{world.Point(12), world.Number(0, 0.3)};
      if (!raster.HasSeenPast(ball.center, ball.radius_m)) continue;
      ++seen;
      EXPECT_FALSE(SomethingIsBefore(mesh, CameraCenter(pose), ball, &world)) << seed;
    }
  }
  EXPECT_GT(seen, 20);
}

TEST(FaceClusters, HoldEachFaceOnceInsideTheBallOfItsCluster) {
  RandomWorld world(7);
  const TriangleMesh mesh = world.Mesh();
  const FaceClusters surface(mesh, {}, 24);
  EXPECT_EQ(surface.faces.size(), mesh.faces.size());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), expected = sum;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (const int v : face) expected += mesh.vertices[static_cast<std::size_t>(v)];
  }
  for (const FaceClusters::Cluster& cluster : surface.clusters) {
    EXPECT_LE(cluster.end_face - cluster.first_face, 24U);
    EXPECT_GT(cluster.end_face, cluster.first_face);
    for (std::uint32_t f = cluster.first_face; f < cluster.end_face; ++f) {
      for (const std::uint32_t v : surface.faces[f].vertices) {
        ASSERT_LT(cluster.first_vertex + v, cluster.end_vertex);
        const Eigen::Vector3d& vertex = surface.vertices[cluster.first_vertex + v];
        EXPECT_LE((vertex - cluster.center).norm(), cluster.radius_m);
        sum += vertex;
      }
    }
  }
  EXPECT_LT((sum - expected).norm(), 1e-6);
  EXPECT_TRUE(FaceClusters(TriangleMesh{}, {}).clusters.empty());
}

}  // namespace
}  // namespace colmap_ext
