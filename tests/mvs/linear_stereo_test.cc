#include "colmap_ext/mvs/linear_stereo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "mvs/analytic_scene.h"
#include "mvs/facet_system.h"
#include "mvs/raster.h"

namespace colmap_ext {
namespace {

using test::AnalyticScene;
using test::AnalyticSurvey;
using test::LookAt;
using test::Rectangle;

Rectangle Ground(double size) {
  return {{-size / 2, -size / 2, 0}, {size, 0, 0}, {0, size, 0}, {110, 130, 120}};
}

ViewMesh SolveFirst(const PhotoSet& photos, const SuperpixelStereoOptions& options = {}) {
  const PosedPhoto& photo = photos.photos[0];
  const ImageMesh mesh = SegmentPhoto(photo.bgr, {});
  const cv::Mat1i ids = RasterizeTriangleIds(mesh, photo.camera.width, photo.camera.height);
  return LinearStereo(photos, 0, PointsOfPhotos(photos)[0], mesh, ids, options).initial();
}

// Largest relative depth error over all triangle corners, for a plane n · X = 1 in the camera.
double PlaneError(const ViewMesh& view, const Eigen::Vector3d& plane_in_cam) {
  double worst = 0;
  for (std::size_t t = 0; t < view.inverse_depth.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(view.image.triangles[t][k]);
      const double truth = plane_in_cam.dot(view.camera.Ray(view.image.vertices_px[v]));
      worst = std::max(worst, std::abs(view.inverse_depth[t][k] / truth - 1));
    }
  }
  return worst;
}

Eigen::Vector3d GroundPlaneInCam(const Rigid3d& cam_from_world) {
  const Eigen::Vector3d normal = cam_from_world.rotation * Eigen::Vector3d::UnitZ();
  return normal / normal.dot(cam_from_world.translation);
}

TEST(LinearStereo, APlaneComesBackAsThatPlane) {
  const AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 300);
  const ViewMesh view = SolveFirst(survey.photos);
  EXPECT_LT(PlaneError(view, GroundPlaneInCam(view.cam_from_world)), 1e-9);
}

TEST(LinearStereo, ThreePointsAreEnoughForAPlane) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 3);
  for (std::size_t p = 0; p < 3; ++p) {
    const double x[] = {-3, 3, 0}, y[] = {-1, -1, 3};
    survey.photos.points[p].position = {x[p], y[p], 0};
  }
  const ViewMesh view = SolveFirst(survey.photos);
  EXPECT_LT(PlaneError(view, GroundPlaneInCam(view.cam_from_world)), 1e-6);
}

TEST(LinearStereo, ScaleOfTheWorldDoesNotMatter) {
  const std::vector<Rigid3d> poses{LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})};
  AnalyticScene scene{{Ground(60)}};
  scene.rectangles.push_back({{-2, -2, 1.5}, {4, 0, 0}, {0, 4, 0}, {60, 60, 200}, 9});
  AnalyticSurvey survey = test::Survey(scene, test::TestCamera(), poses, 300);
  const ViewMesh meters = SolveFirst(survey.photos);
  for (PosedPhoto& photo : survey.photos.photos) photo.cam_from_world.translation *= 1000;
  for (SupportPoint& point : survey.photos.points) point.position *= 1000;
  const ViewMesh millimeters = SolveFirst(survey.photos);
  for (std::size_t t = 0; t < meters.inverse_depth.size(); ++t) {
    EXPECT_LT((meters.inverse_depth[t] - 1000 * millimeters.inverse_depth[t]).norm(), 1e-9);
  }
}

TEST(LinearStereo, OneBadPointDoesNotBendAFacet) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 300);
  const Eigen::Vector3d center = CameraCenter(survey.photos.photos[0].cam_from_world);
  for (std::size_t p = 0; p < survey.photos.points.size(); p += 20) {  // one in twenty
    Eigen::Vector3d& position = survey.photos.points[p].position;
    position = center + (p % 40 == 0 ? 0.6 : 1.5) * (position - center);
  }
  const ViewMesh view = SolveFirst(survey.photos);
  EXPECT_LT(PlaneError(view, GroundPlaneInCam(view.cam_from_world)), 0.03);
}

// A red table before a grey floor, seen from above.
struct StepScene {
  StepScene() {
    AnalyticScene scene{{Ground(60)}};
    scene.rectangles[0].contrast = 25;
    scene.rectangles.push_back({{-2, -3, 3}, {4, 0, 0}, {0, 6, 0}, {40, 40, 220}, 9, 25});
    survey =
        test::Survey(scene, test::TestCamera(),
                     {LookAt({0, -0.5, 12}, {0, 0, 0}), LookAt({2, -0.5, 12}, {0, 0, 0})}, 500);
  }
  AnalyticSurvey survey;
};

TEST(LinearStereo, ADepthEdgeStaysAnEdge) {
  const StepScene step;
  const ViewMesh view = SolveFirst(step.survey.photos);
  const cv::Mat1i ids = TriangleIdMap(view);
  const ViewLookup lookup(view, ids);
  const cv::Mat1d& truth = step.survey.depth[0];
  // Rows that cross the edge of the table: 4 px to either side the depth must be right already. A
  // C0 surface would need the width of a triangle (some 15 px) to come down.
  int tested = 0;
  int right = 0;
  for (int y = 60; y < 180; ++y) {
    for (int x = 10; x < 310; ++x) {
      if (std::abs(truth(y, x) - truth(y, x - 1)) < 1) continue;
      for (const int side : {-5, 4}) {
        const Eigen::Vector2d pixel(x + side + 0.5, y + 0.5);
        const double depth = 1.0 / lookup.InverseDepth(lookup.TriangleAt(pixel), pixel);
        ++tested;
        right += std::abs(depth / truth(y, x + side) - 1) < 0.06;
      }
    }
  }
  ASSERT_GT(tested, 200);
  EXPECT_GT(static_cast<double>(right) / tested, 0.9);
}

TEST(LinearStereo, CornersAtOneVertexMayDisagree) {
  const StepScene step;
  const ViewMesh view = SolveFirst(step.survey.photos);
  std::vector<double> low(view.image.vertices_px.size(), 1e9);
  std::vector<double> high(view.image.vertices_px.size(), 0);
  for (std::size_t t = 0; t < view.inverse_depth.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(view.image.triangles[t][k]);
      low[v] = std::min(low[v], 1 / view.inverse_depth[t][k]);
      high[v] = std::max(high[v], 1 / view.inverse_depth[t][k]);
    }
  }
  int jumps = 0;
  for (std::size_t v = 0; v < low.size(); ++v) jumps += high[v] - low[v] > 1.5;
  EXPECT_GT(jumps, 20);  // along the table's outline
}

TEST(LinearStereo, WithoutPointsNothingIsInvented) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(), {LookAt({0, -12, 9}, {0, 0, 0})}, 0);
  const ViewMesh view = SolveFirst(survey.photos);
  for (std::size_t t = 0; t < view.inverse_depth.size(); ++t) {
    EXPECT_EQ(view.supported[t], 0);
    EXPECT_EQ(view.inverse_depth[t], Eigen::Vector3d::Zero());
  }
}

TEST(LinearStereo, ARegionFarFromEveryPointIsMarked) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 400);
  const PosedPhoto& photo = survey.photos.photos[0];
  std::erase_if(survey.photos.points, [&](const SupportPoint& point) {
    return photo.camera.Project(photo.cam_from_world * point.position).x() > 100;
  });
  const ViewMesh view = SolveFirst(survey.photos);
  for (std::size_t t = 0; t < view.inverse_depth.size(); ++t) {
    const double x =
        view.image.vertices_px[static_cast<std::size_t>(view.image.triangles[t][0])].x();
    EXPECT_TRUE(view.inverse_depth[t].allFinite());
    if (x > 240) {
      EXPECT_EQ(view.supported[t], 0);
    } else if (x < 80) {
      EXPECT_EQ(view.supported[t], 1);
    }
  }
}

TEST(LinearStereo, OnePointAloneGivesItsDepthAround) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 1);
  survey.photos.points[0].position = {0, 0, 0};
  const ViewMesh view = SolveFirst(survey.photos);
  const ViewLookup lookup(view, TriangleIdMap(view));
  const Eigen::Vector2d pixel(160, 120);
  EXPECT_NEAR(1 / lookup.InverseDepth(lookup.TriangleAt(pixel), pixel), 15.0, 0.01);
  for (const Eigen::Vector3d& depth : view.inverse_depth) EXPECT_TRUE(depth.allFinite());
}

// The energy of the paper, straight from its equations, for the system's matrix to be held against.
double Energy(const ImageMesh& mesh, const std::vector<FacetEdge>& edges,
              const std::vector<DepthRow>& rows, const std::vector<Eigen::Vector3d>& d,
              double smoothness, double continuity) {
  double energy = 0;
  for (const DepthRow& row : rows) {
    const double residual =
        row.inverse_depth - row.barycentric.dot(d[static_cast<std::size_t>(row.triangle)]);
    energy += row.weight * residual * residual;
  }
  for (const FacetEdge& edge : edges) {
    for (int side = 0; side < 2; ++side) {
      const auto t = static_cast<std::size_t>(edge.triangle[side]);
      const auto other = static_cast<std::size_t>(edge.triangle[1 - side]);
      const auto corner = [&](int k) {
        return mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][k])];
      };
      const int apex = edge.opposite[1 - side];
      const Eigen::Vector3d beta =
          Barycentric(corner(0), corner(1), corner(2),
                      mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[other][apex])]);
      const double residual = d[other][apex] - beta.dot(d[t]);
      energy += smoothness * edge.color_weight * residual * residual / (1 + beta.squaredNorm());
      for (int a = 0; a < 3 && side == 0; ++a) {
        for (int b = 0; b < 3; ++b) {
          if (mesh.triangles[t][a] != mesh.triangles[other][b]) continue;
          energy += continuity * edge.color_weight * std::pow(d[t][a] - d[other][b], 2);
        }
      }
    }
  }
  return energy;
}

class FacetSystemTest : public ::testing::Test {
 protected:
  FacetSystemTest() {
    cv::Mat photo(60, 80, CV_8UC3);
    cv::RNG(3).fill(photo, cv::RNG::UNIFORM, 0, 256);
    mesh_ = SegmentPhoto(photo, {});
    edges_ = CollectEdges(mesh_, {});
    for (std::size_t t = 0; t < mesh_.triangles.size(); t += 3) {
      const double a = Number(), b = Number() * (1 - a);
      rows_.push_back({static_cast<int>(t), {a, b, 1 - a - b}, 0.5 + Number(), 0.1 + Number()});
    }
  }
  double Number() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double EnergyOf(const std::vector<Eigen::Vector3d>& d) const {
    return Energy(mesh_, edges_, rows_, d, 0.3, 0.2);
  }
  bool Solve(const std::vector<std::uint8_t>& fixed, std::vector<Eigen::Vector3d>* d) const {
    const FacetSystem system(mesh_.triangles.size(), edges_, 0.1, 0.2 / 3);
    return FacetSolver(system, fixed).Solve(3.0, rows_, d);
  }
  // Largest derivative of the energy by a depth of the free triangles (central differences, exact
  // for a quadratic).
  double LargestGradient(std::vector<Eigen::Vector3d> d, const std::vector<std::uint8_t>& fixed) {
    constexpr double kStep = 1e-3;
    double largest = 0;
    for (std::size_t t = 0; t < d.size(); ++t) {
      if (!fixed.empty() && fixed[t] != 0) continue;
      for (int k = 0; k < 3; ++k) {
        const double value = d[t][k];
        d[t][k] = value + kStep;
        const double high = EnergyOf(d);
        d[t][k] = value - kStep;
        const double low = EnergyOf(d);
        d[t][k] = value;
        largest = std::max(largest, std::abs(high - low) / (2 * kStep));
      }
    }
    return largest;
  }

  std::mt19937 random_{5};
  ImageMesh mesh_;
  std::vector<FacetEdge> edges_;
  std::vector<DepthRow> rows_;
};

TEST_F(FacetSystemTest, SolutionIsAMinimumOfTheEnergy) {
  std::vector<Eigen::Vector3d> d(mesh_.triangles.size(), Eigen::Vector3d::Constant(0.7));
  EXPECT_GT(LargestGradient(d, {}), 1e-2);
  ASSERT_TRUE(Solve({}, &d));
  EXPECT_LT(LargestGradient(d, {}), 1e-9);
}

TEST_F(FacetSystemTest, FixedTrianglesKeepTheirDepthAndTheRestIsOptimal) {
  std::vector<Eigen::Vector3d> d;
  std::vector<std::uint8_t> fixed;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    d.emplace_back(0.5 + Number(), 0.5 + Number(), 0.5 + Number());
    fixed.push_back(t % 2 == 0);
  }
  const std::vector<Eigen::Vector3d> before = d;
  ASSERT_TRUE(Solve(fixed, &d));
  for (std::size_t t = 0; t < d.size(); t += 2) EXPECT_EQ(d[t], before[t]);
  EXPECT_LT(LargestGradient(d, fixed), 1e-9);
}

TEST_F(FacetSystemTest, EverythingFixedIsNoError) {
  std::vector<Eigen::Vector3d> d(mesh_.triangles.size(), Eigen::Vector3d::Constant(0.7));
  const std::vector<std::uint8_t> fixed(mesh_.triangles.size(), 1);
  EXPECT_TRUE(Solve(fixed, &d));
}

TEST(SuperpixelStereoOptions, SayWhatIsWrong) {
  SuperpixelStereoOptions options;
  EXPECT_EQ(options.Check(), "");
  options.sigma_view = -1;
  EXPECT_NE(options.Check().find("SuperpixelStereo.sigma_view is -1"), std::string::npos);
  options = {};
  options.fixed_confidence = std::nan("");
  EXPECT_NE(options.Check(), "");
}

// As photo-consistency gives them: one row about the depth at the centroid, two about the slant.
std::vector<DepthRow> DepthAndSlantRows(const ViewMesh& view, const Eigen::Vector3d& plane_in_cam,
                                        double factor) {
  std::vector<DepthRow> rows;
  for (std::size_t t = 0; t < view.image.triangles.size(); ++t) {
    Eigen::Vector3d corners;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(view.image.triangles[t][k]);
      corners[k] = plane_in_cam.dot(view.camera.Ray(view.image.vertices_px[v]));
    }
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-1, 1, 0), Eigen::Vector3d(0, -1, 1)}) {
      DepthRow row;
      row.triangle = static_cast<int>(t);
      row.barycentric = factor * direction;
      row.inverse_depth = row.barycentric.dot(corners);
      rows.push_back(row);
    }
  }
  return rows;
}

TEST(LinearStereo, AViewWithoutPointsFollowsRowsThatDoNotSumToOne) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 300);
  survey.photos.points.clear();
  const PosedPhoto& photo = survey.photos.photos[0];
  const ImageMesh mesh = SegmentPhoto(photo.bgr, {});
  const LinearStereo stereo(survey.photos, 0, {}, mesh,
                            RasterizeTriangleIds(mesh, photo.camera.width, photo.camera.height),
                            {});
  const Eigen::Vector3d plane = GroundPlaneInCam(photo.cam_from_world);
  const std::vector<std::uint8_t> none_fixed(mesh.triangles.size(), 0);
  for (const double factor : {1.0, 40.0, -3.0}) {
    ViewMesh view = stereo.initial();
    EXPECT_EQ(view.supported[0], 0);
    stereo.Refine(none_fixed, DepthAndSlantRows(view, plane, factor), &view);
    EXPECT_LT(PlaneError(view, plane), 1e-6) << factor;
    EXPECT_EQ(*std::min_element(view.supported.begin(), view.supported.end()), 1);
  }
}

TEST(LinearStereo, AViewWithNothingButSlantsIsLeftAlone) {
  AnalyticSurvey survey =
      test::Survey({{Ground(60)}}, test::TestCamera(),
                   {LookAt({0, -12, 9}, {0, 0, 0}), LookAt({3, -12, 9}, {0, 0, 0})}, 300);
  survey.photos.points.clear();
  const PosedPhoto& photo = survey.photos.photos[0];
  const ImageMesh mesh = SegmentPhoto(photo.bgr, {});
  const LinearStereo stereo(survey.photos, 0, {}, mesh,
                            RasterizeTriangleIds(mesh, photo.camera.width, photo.camera.height),
                            {});
  ViewMesh view = stereo.initial();
  std::vector<DepthRow> rows = DepthAndSlantRows(view, GroundPlaneInCam(photo.cam_from_world), 1.0);
  std::erase_if(rows, [](const DepthRow& row) { return row.barycentric.sum() != 0; });
  stereo.Refine(std::vector<std::uint8_t>(mesh.triangles.size(), 0), rows, &view);
  EXPECT_EQ(view.inverse_depth, stereo.initial().inverse_depth);
  EXPECT_EQ(view.supported, stereo.initial().supported);
}

}  // namespace
}  // namespace colmap_ext
