#include "colmap_ext/surface/poisson.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <limits>

#include "colmap_ext/util/error.h"
#include "surface/sampled_shapes.h"

namespace colmap_ext {
namespace {

using ::testing::HasSubstr;

const RegionOfInterest kPlaneRegion = Region({0, 0, -2}, {10, 10, 2});
const RegionOfInterest kSphereRegion = Region({95, -5, -5}, {105, 5, 5});

Surface SphereSurface(double noise_m) {
  SurfaceOptions options;
  options.resolution_m = 0.2;
  return ReconstructSurface(SpherePoints({100, 0, 0}, 4, 20000, noise_m), kSphereRegion, options,
                            JobControl());
}

double MedianSpacingInside(const Surface& surface, double x0, double x1) {
  std::vector<double> spacings;
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& v = surface.mesh.vertices[i];
    if (v.x() > x0 && v.x() < x1 && v.y() > 2 && v.y() < 8) {
      spacings.push_back(surface.sample_spacing_m[i]);
    }
  }
  if (spacings.empty()) return -1;
  std::sort(spacings.begin(), spacings.end());
  return spacings[spacings.size() / 2];
}

std::string MessageOf(const OrientedPoints& points, const RegionOfInterest& region,
                      const SurfaceOptions& options) {
  try {
    ReconstructSurface(points, region, options, JobControl());
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

bool SameSurface(const Surface& a, const Surface& b) {
  return a.mesh.vertices == b.mesh.vertices && a.mesh.faces == b.mesh.faces &&
         a.sample_spacing_m == b.sample_spacing_m && a.scatter_m == b.scatter_m &&
         a.color == b.color;
}

TEST(ReconstructSurface, SphereComesBackWhereItIs) {
  const Surface surface = SphereSurface(0.01);
  ASSERT_GT(surface.mesh.vertices.size(), 2000U);
  double squared_error = 0;
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
    const double error = (vertex - Eigen::Vector3d(100, 0, 0)).norm() - 4;
    squared_error += error * error;
    EXPECT_LT(std::abs(error), 0.08);
  }
  EXPECT_LT(std::sqrt(squared_error / static_cast<double>(surface.mesh.vertices.size())), 0.015);
}

TEST(ReconstructSurface, FacesTurnOutwards) {
  const Surface surface = SphereSurface(0);
  for (std::size_t f = 0; f < surface.mesh.faces.size(); ++f) {
    if (FaceArea(surface.mesh, f) < 1e-6) continue;
    const Eigen::Vector3d corner =
        surface.mesh.vertices[static_cast<std::size_t>(surface.mesh.faces[f][0])];
    EXPECT_GT(FaceNormal(surface.mesh, f).dot(corner - Eigen::Vector3d(100, 0, 0)), 0);
  }
}

TEST(ReconstructSurface, EveryVertexHasColourAndSignalAndAFace) {
  const Surface surface = SphereSurface(0.01);
  const std::size_t count = surface.mesh.vertices.size();
  ASSERT_EQ(surface.color.size(), count);
  ASSERT_EQ(surface.sample_spacing_m.size(), count);
  ASSERT_EQ(surface.scatter_m.size(), count);
  std::vector<bool> is_used(count, false);
  for (const Eigen::Vector3i& face : surface.mesh.faces) {
    for (int k = 0; k < 3; ++k) is_used[static_cast<std::size_t>(face[k])] = true;
  }
  EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
  for (const Eigen::Vector3d& color : surface.color) {
    EXPECT_NEAR(color.x(), 200 / 255.0, 0.02);
    EXPECT_NEAR(color.z(), 50 / 255.0, 0.02);
  }
}

// Points that lie, in turn, above and below a plane.
double MedianScatterOfPlane(double offset_m) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.1, -1, &points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position.z() += i % 2 == 0 ? offset_m : -offset_m;
  }
  SurfaceOptions options;
  options.resolution_m = 0.4;
  const Surface surface = ReconstructSurface(points, kPlaneRegion, options, JobControl());
  EXPECT_EQ(surface.scatter_m.size(), surface.mesh.vertices.size());
  std::vector<double> scatter;
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& v = surface.mesh.vertices[i];
    if (v.x() > 2 && v.x() < 8 && v.y() > 2 && v.y() < 8) scatter.push_back(surface.scatter_m[i]);
  }
  EXPECT_GT(scatter.size(), 50U);
  std::sort(scatter.begin(), scatter.end());
  return scatter[scatter.size() / 2];
}

TEST(ReconstructSurface, ScatterIsHowFarThePointsLieFromIt) {
  EXPECT_LT(MedianScatterOfPlane(0), 0.003);
  EXPECT_NEAR(MedianScatterOfPlane(0.03), 0.03, 0.003);  // merged by thinning: two a voxel
  EXPECT_NEAR(MedianScatterOfPlane(0.08), 0.08, 0.008);
}

TEST(ReconstructSurface, SignalOfAGridIsItsSpacing) {
  for (const double spacing : {0.05, 0.1, 0.2, 0.4}) {
    OrientedPoints points;
    AppendPlane(0, 0, 10, 10, 0, spacing, -1, &points);
    SurfaceOptions options;
    options.resolution_m = 0.2;
    const Surface surface = ReconstructSurface(points, kPlaneRegion, options, JobControl());
    EXPECT_NEAR(MedianSpacingInside(surface, 2, 8) / spacing, 1.0, 0.12) << spacing;
  }
}

TEST(ReconstructSurface, SignalDoesNotDependOnTheResolution) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.05, -1, &points);
  SurfaceOptions coarse, fine;
  coarse.resolution_m = 0.5;
  fine.resolution_m = 0.15;
  const double of_coarse =
      MedianSpacingInside(ReconstructSurface(points, kPlaneRegion, coarse, JobControl()), 2, 8);
  const double of_fine =
      MedianSpacingInside(ReconstructSurface(points, kPlaneRegion, fine, JobControl()), 2, 8);
  EXPECT_NEAR(of_coarse, of_fine, 0.15 * of_fine);
}

TEST(ReconstructSurface, AutomaticCellsAreTwoWantedPixelsWithinTheBudget) {
  const OrientedPoints points = SpherePoints({100, 0, 0}, 4, 80000, 0.005);
  const auto num_vertices = [&points](const SurfaceOptions& options) {
    return static_cast<double>(
        ReconstructSurface(points, kSphereRegion, options, JobControl()).mesh.vertices.size());
  };
  SurfaceOptions by_hand, by_gsd, by_budget;
  by_hand.resolution_m = 0.3;
  by_gsd.ground_sampling_distance_mm = 150;
  EXPECT_EQ(num_vertices(by_gsd), num_vertices(by_hand));
  by_budget.max_vertices = 4000;
  by_budget.ground_sampling_distance_mm = 1;  // finer than what can be paid
  EXPECT_GT(num_vertices(by_budget), 2000);   // the budget is what is aimed at
  EXPECT_LT(num_vertices(by_budget), 8000);
}

TEST(ReconstructSurface, FewerConfidentPointsGiveAWeakerSignal) {
  OrientedPoints points;
  AppendPlane(0, 0, 5, 10, 0, 0.1, -1, &points);
  AppendPlane(5, 0, 10, 10, 0, 0.1, -1, &points);
  for (OrientedPoint& point : points) {
    if (point.position.x() > 5) point.confidence = 0.25F;
  }
  SurfaceOptions options;
  options.resolution_m = 0.2;
  const Surface surface = ReconstructSurface(points, kPlaneRegion, options, JobControl());
  EXPECT_NEAR(MedianSpacingInside(surface, 1, 4), 0.1, 0.015);
  EXPECT_NEAR(MedianSpacingInside(surface, 6, 9), 0.2, 0.03);
}

TEST(ReconstructSurface, OnePhotoAloneGivesNoSignal) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.05, 3, &points);  // dense, but photo 3 only
  AppendPlane(6, 0, 10, 10, 0, 0.1, 4, &points);
  SurfaceOptions options;
  options.resolution_m = 0.2;
  const Surface surface = ReconstructSurface(points, kPlaneRegion, options, JobControl());
  EXPECT_GT(MedianSpacingInside(surface, 1, 5), 5.0);
  EXPECT_NEAR(MedianSpacingInside(surface, 7, 9), 0.1, 0.015);
}

TEST(ReconstructSurface, HolesStayClosedAndFarSurfaceIsTrimmed) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.1, -1, &points);
  std::erase_if(points, [](const OrientedPoint& point) {
    return (point.position - Eigen::Vector3d(5, 5, 0)).norm() < 1.0;
  });
  SurfaceOptions options;
  options.resolution_m = 0.2;
  // The region is larger than what was seen: Poisson would fill it.
  const RegionOfInterest region = Region({-10, -10, -5}, {20, 20, 5});
  const Surface surface = ReconstructSurface(points, region, options, JobControl());
  double nearest_to_hole = 1e9, furthest_outside = 0;
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
    nearest_to_hole = std::min(nearest_to_hole, (vertex - Eigen::Vector3d(5, 5, 0)).norm());
    const Eigen::Vector3d inside =
        vertex.cwiseMax(Eigen::Vector3d(0, 0, 0)).cwiseMin(Eigen::Vector3d(10, 10, 0));
    furthest_outside = std::max(furthest_outside, (vertex - inside).norm());
  }
  EXPECT_LT(nearest_to_hole, 0.3);
  EXPECT_LT(furthest_outside, 6.0);

  SurfaceOptions strict = options;
  strict.trim_spacing_m = 0.2;
  const Surface trimmed = ReconstructSurface(points, region, strict, JobControl());
  for (const Eigen::Vector3d& vertex : trimmed.mesh.vertices) {
    EXPECT_GT((vertex - Eigen::Vector3d(5, 5, 0)).norm(), 0.4);
  }
  EXPECT_LT(trimmed.mesh.faces.size(), surface.mesh.faces.size());
}

// A roof over two walls, seen from above: its underside, and the walls' upper parts, were not.
OrientedPoints RoofOverWalls() {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.1, -1, &points);
  std::erase_if(points, [](const OrientedPoint& point) {
    return point.position.x() > 4 && point.position.x() < 6;
  });
  AppendPlane(2, 0, 8, 10, 3, 0.1, -1, &points);
  for (double y = 0.05; y < 10; y += 0.1) {
    for (double z = 0.05; z < 2.2; z += 0.1) {
      points.push_back(MakePoint({4, y, z}, {-1, 0, 0}));
      points.push_back(MakePoint({6, y, z}, {1, 0, 0}));
    }
    for (double z = 2.75; z < 3; z += 0.1) {
      points.push_back(MakePoint({2, y, z}, {-1, 0, 0}));
      points.push_back(MakePoint({8, y, z}, {1, 0, 0}));
    }
  }
  return points;
}

TEST(ReconstructSurface, UndersidesThatNobodySawStayClosed) {
  SurfaceOptions options;
  options.resolution_m = 0.2;
  options.trim_spacing_m = 0.6;
  const RegionOfInterest region = Region({1, 1, -1}, {9, 9, 4});
  const Surface surface = ReconstructSurface(RoofOverWalls(), region, options, JobControl());
  double area = 0;
  for (std::size_t f = 0; f < surface.mesh.faces.size(); ++f) {
    const auto vertex = static_cast<std::size_t>(surface.mesh.faces[f][0]);
    const Eigen::Vector3d& corner = surface.mesh.vertices[vertex];
    const bool is_under_eaves = corner.x() > 2.3 && corner.x() < 3.7 && corner.z() > 1;
    if (!is_under_eaves || FaceNormal(surface.mesh, f).z() > -0.5) continue;
    area += FaceArea(surface.mesh, f);
    EXPECT_GT(surface.sample_spacing_m[vertex], 0.15);  // there, but without the grid's signal
  }
  EXPECT_GT(area, 0.8 * 1.4 * 8);
}

TEST(ReconstructSurface, NothingOutsideTheWidenedRegion) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.1, -1, &points);
  SurfaceOptions options;
  options.resolution_m = 0.2;
  options.crop_margin_ratio = 0.1;
  const RegionOfInterest region = Region({3, 3, -1}, {6, 6, 1});
  const double margin = 0.1 * region.box.diagonal().norm();
  const Surface surface = ReconstructSurface(points, region, options, JobControl());
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
    EXPECT_LE(region.box.exteriorDistance(vertex), 2 * margin);
    EXPECT_GE(vertex.x(), 3 - margin);
    EXPECT_LE(vertex.x(), 6 + margin);
  }
}

TEST(ReconstructSurface, CrumbsAreDropped) {
  OrientedPoints points = SpherePoints({100, 0, 0}, 3, 20000, 0);
  const OrientedPoints crumb = SpherePoints({104, 4, 4}, 0.1, 500, 0);
  points.insert(points.end(), crumb.begin(), crumb.end());
  SurfaceOptions options;
  options.resolution_m = 0.1;
  const Surface surface = ReconstructSurface(points, kSphereRegion, options, JobControl());
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
    EXPECT_LT((vertex - Eigen::Vector3d(100, 0, 0)).norm(), 3.5);
  }
}

TEST(ReconstructSurface, SameResultEachTimeWhateverTheThreads) {
  const Surface first = SphereSurface(0.01);
  const Surface again = SphereSurface(0.01);
  EXPECT_TRUE(SameSurface(first, again));
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(SameSurface(first, SphereSurface(0.01)));
}

TEST(ReconstructSurface, PrintsNothing) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.1, -1, &points);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  SurfaceOptions options;
  options.depth = 7;
  ReconstructSurface(points, kPlaneRegion, options, JobControl());
  const std::string out = ::testing::internal::GetCapturedStdout();
  const std::string err = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(out, "");
  EXPECT_EQ(err, "");
}

TEST(ReconstructSurface, AutomaticResolutionBoundsTheSize) {
  const Surface surface = ReconstructSurface(SpherePoints({100, 0, 0}, 4, 100000, 0.005),
                                             kSphereRegion, SurfaceOptions(), JobControl());
  EXPECT_GT(surface.mesh.vertices.size(), 30000U);
  EXPECT_LT(surface.mesh.vertices.size(), 100000U);
}

TEST(ReconstructSurface, TooFewPointsIsAClearError) {
  EXPECT_THAT(MessageOf({}, kPlaneRegion, {}), HasSubstr("only 0 of 0 points"));
  OrientedPoints points;
  AppendPlane(50, 50, 60, 60, 0, 0.1, -1, &points);
  EXPECT_THAT(MessageOf(points, kPlaneRegion, {}), HasSubstr("in the region of interest"));
}

TEST(ReconstructSurface, BadPointsAreNamedOrLeftOut) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.2, -1, &points);
  points[11].normal.setZero();  // COLMAP writes such points: they say nothing of a side
  SurfaceOptions coarse;
  coarse.resolution_m = 0.5;
  EXPECT_EQ(MessageOf(points, kPlaneRegion, coarse), "no error");
  points[17].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(MessageOf(points, kPlaneRegion, {}), HasSubstr("point 17 of the fused cloud"));
  const OrientedPoints same_place(100, MakePoint({1, 1, 0}, {0, 0, 1}));
  EXPECT_THAT(MessageOf(same_place, kPlaneRegion, {}), HasSubstr("same place"));
}

TEST(ReconstructSurface, TrimmingEverythingAwayIsAnError) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.2, -1, &points);
  SurfaceOptions options;
  options.resolution_m = 0.5;
  options.trim_spacing_m = 0.01;
  EXPECT_THAT(MessageOf(points, kPlaneRegion, options), HasSubstr("trim_spacing_m"));
}

TEST(ReconstructSurface, StopsWhenCancelled) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.2, -1, &points);
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(ReconstructSurface(points, kPlaneRegion, {}, JobControl(nullptr, &cancel)),
               CancelledError);
}

TEST(SurfaceOptions, CheckNamesTheOptionAndItsRange) {
  EXPECT_EQ(SurfaceOptions().Check(), "");
  SurfaceOptions options;
  options.depth = 3;
  EXPECT_THAT(options.Check(), HasSubstr("depth"));
  options = {};
  options.resolution_m = -1;
  EXPECT_THAT(options.Check(), HasSubstr("resolution_m"));
  options = {};
  options.trim_spacing_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(options.Check(), HasSubstr("trim_spacing_m"));
  options = {};
  options.crop_margin_ratio = 2;
  EXPECT_THAT(options.Check(), HasSubstr("crop_margin_ratio"));
  EXPECT_THROW(ReconstructSurface({}, kPlaneRegion, options, JobControl()), UsageError);
}

}  // namespace
}  // namespace colmap_ext
