#include "colmap_ext/coverage/iso_points.h"

#include <gtest/gtest.h>

#include <random>

#include "colmap_ext/util/error.h"
#include "coverage/test_scene.h"

namespace colmap_ext {
namespace {

double SmallestDistance(const std::vector<IsoPoint>& points) {
  double smallest = 1e9;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      smallest = std::min(smallest, (points[i].position - points[j].position).norm());
    }
  }
  return smallest;
}

TEST(SampleIsoPoints, KeepTheirDistanceAndShareTheArea) {
  const IsoPoints iso = SampleIsoPoints(Wall(), 0.25, 1);
  EXPECT_EQ(iso.spacing_m, 0.25);
  EXPECT_GE(SmallestDistance(iso.points), 0.25);
  EXPECT_NEAR(iso.disk_area_m2 * static_cast<double>(iso.points.size()), 60.0, 1e-9);
  // A maximal sampling has about 0.7 points per squared distance.
  EXPECT_NEAR(static_cast<double>(iso.points.size()) * 0.25 * 0.25 / 60.0, 0.7, 0.1);
  for (const IsoPoint& point : iso.points) {
    EXPECT_NEAR(point.position.y(), 0, 1e-12);
    EXPECT_NEAR((point.normal - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-12);
  }
}

// Blue noise: zones of equal area hold equally many points, far more equally than chance would, on
// triangles of very different sizes.
TEST(SampleIsoPoints, DensityIsEvenOverTheSurface) {
  constexpr int kZones = 8;
  Surface surface;
  surface.mesh = Ball({0, 0, 0}, 10, 40);  // its triangles shrink towards the poles
  for (const std::uint64_t seed : {1, 2, 3}) {
    const IsoPoints iso = SampleIsoPoints(surface, 0, seed);
    EXPECT_GE(SmallestDistance(iso.points), iso.spacing_m);
    // Slices of a sphere of equal height have equal areas.
    std::vector<double> count(kZones, 0.0);
    for (const IsoPoint& point : iso.points) {
      const double height = (point.position.z() + 10) / 20;
      count[std::min<std::size_t>(kZones - 1, static_cast<std::size_t>(height * kZones))] += 1;
    }
    const double mean = static_cast<double>(iso.points.size()) / kZones;
    double squares = 0;
    for (const double zone : count) {
      EXPECT_NEAR(zone, mean, 0.1 * mean);
      squares += (zone - mean) * (zone - mean);
    }
    EXPECT_LT(squares / kZones, 0.5 * mean) << "points thrown at random have a variance of 1 mean";
  }
}

TEST(SampleIsoPoints, AutomaticSpacingGivesFiveToTenThousand) {
  for (const double radius : {0.5, 20.0}) {
    Surface surface;
    surface.mesh = Ball({0, 0, 0}, radius, 40);
    const IsoPoints iso = SampleIsoPoints(surface, 0, 1);
    EXPECT_GT(iso.points.size(), 5000U);
    EXPECT_LT(iso.points.size(), 10000U);
  }
}

TEST(SampleIsoPoints, SignalIsInterpolatedOnTheFace) {
  Surface surface = Wall();
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
    surface.sample_spacing_m.push_back(1 + 0.1 * vertex.x() + 0.02 * vertex.z());
    surface.scatter_m.push_back(2 - 0.1 * vertex.z());
  }
  for (const IsoPoint& point : SampleIsoPoints(surface, 0.3, 1).points) {
    EXPECT_NEAR(point.sample_spacing_m, 1 + 0.1 * point.position.x() + 0.02 * point.position.z(),
                1e-9);
    EXPECT_NEAR(point.scatter_m, 2 - 0.1 * point.position.z(), 1e-9);
  }
}

TEST(SampleIsoPoints, RoughnessOfLittleFacesIsSmoothed) {
  Surface surface;
  AppendPanel({-5, 0, 0}, {10, 0, 0}, {0, 0, 6}, 100, &surface.mesh);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  for (Eigen::Vector3d& vertex : surface.mesh.vertices) vertex.y() += noise(random);
  const auto mean_slant = [&surface](double spacing_m) {
    double sum = 0;
    const IsoPoints iso = SampleIsoPoints(surface, spacing_m, 1);
    for (const IsoPoint& point : iso.points) sum += std::acos(-point.normal.y());
    return sum / static_cast<double>(iso.points.size());
  };
  EXPECT_LT(mean_slant(0.3), 0.6 * mean_slant(0.15));  // edges of 0.06 to 0.12 m
}

TEST(SampleIsoPoints, LargeFacesKeepTheirNormals) {
  Surface cube;
  for (const double z : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      for (const double x : {0.0, 1.0}) cube.mesh.vertices.emplace_back(x, y, z);
    }
  }
  cube.mesh.faces = {{4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}};  // top and south
  for (const IsoPoint& point : SampleIsoPoints(cube, 0.1, 1).points) {
    EXPECT_NEAR(point.normal.cwiseAbs().maxCoeff(), 1, 1e-12);
  }
}

TEST(SampleIsoPoints, WithoutSignalThereIsNoSupport) {
  for (const IsoPoint& point : SampleIsoPoints(Wall(), 1, 1).points) {
    EXPECT_NEAR(point.sample_spacing_m, std::sqrt(136.0), 1e-9);
  }
}

TEST(SampleIsoPoints, SameSeedSamePoints) {
  const IsoPoints a = SampleIsoPoints(Wall(), 0.3, 5), b = SampleIsoPoints(Wall(), 0.3, 5);
  const IsoPoints c = SampleIsoPoints(Wall(), 0.3, 6);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].position, b.points[i].position);
  }
  EXPECT_NE(a.points[0].position, c.points[0].position);
}

TEST(SampleIsoPoints, BadSurfacesAreRefused) {
  EXPECT_THROW(SampleIsoPoints(Surface(), 0, 1), Error);
  Surface flat;
  flat.mesh.vertices.assign(3, Eigen::Vector3d::Zero());
  flat.mesh.faces.emplace_back(0, 1, 2);
  EXPECT_THROW(SampleIsoPoints(flat, 0, 1), Error);
  Surface wrong = Wall();
  wrong.sample_spacing_m = {1, 2, 3};
  EXPECT_THROW(SampleIsoPoints(wrong, 0, 1), Error);
}

}  // namespace
}  // namespace colmap_ext
