#include "colmap_ext/report/session_pictures.h"

#include <gtest/gtest.h>

#include "colmap_ext/report/photo_picture.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// A ground of 10 m x 10 m in n x n cells.
TriangleMesh Ground(int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) mesh.vertices.emplace_back(10.0 * i / n, 10.0 * j / n, 0);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      mesh.faces.emplace_back(a, a + 1, a + n + 2);
      mesh.faces.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
  return mesh;
}

// Uncovered for x < 5, covered to the right, ignored in the north (y > 8).
CoverageMap HalfCovered() {
  CoverageMap map;
  map.disk_area_m2 = M_PI * 0.1 * 0.1;
  for (double y = 0.1; y < 10; y += 0.2) {
    for (double x = 0.1; x < 10; x += 0.2) {
      IsoPoint point;
      point.position = {x, y, 0};
      point.normal = {0, 0, 1};
      point.coverage = x < 5 ? CoverageClass::kUncovered : CoverageClass::kCovered;
      if (y > 8) point.coverage = CoverageClass::kIgnored;
      map.points.push_back(point);
    }
  }
  return map;
}

// The picture seen from straight above, north up: the whole ground fills the height.
PictureView FromAbove(const TriangleMesh& mesh) {
  PictureView view;
  view.direction = {0, -M_PI / 2};
  view.focus = mesh.vertices;
  return view;
}

// Which of the three class colours a pixel has (they are lit, so only roughly).
CoverageClass NearestClass(const cv::Vec3b& bgr) {
  CoverageClass best = CoverageClass::kUncovered;
  double best_angle = 1e9;
  const Rgb color(static_cast<float>(bgr[2]), static_cast<float>(bgr[1]),
                  static_cast<float>(bgr[0]));
  for (const CoverageClass coverage :
       {CoverageClass::kUncovered, CoverageClass::kCovered, CoverageClass::kIgnored}) {
    const double angle = (ColorOf(coverage).normalized() - color.normalized()).norm();
    if (angle < best_angle) {
      best_angle = angle;
      best = coverage;
    }
  }
  EXPECT_LT(best_angle, 0.12);
  return best;
}

class CoveragePictureTest : public ::testing::TestWithParam<int> {};

TEST_P(CoveragePictureTest, EachClassIsWhereItBelongs) {
  // Two faces, or many smaller than the spacing of the iso-points: the same picture.
  const TriangleMesh mesh = Ground(GetParam());
  const cv::Mat bgr = RenderCoverageMap(MeshPainter(mesh), HalfCovered(), FromAbove(mesh));
  ASSERT_EQ(bgr.size(), cv::Size(1280, 800));
  // 10 m fill 90 % of 800 px: 72 px a metre around the centre (640, 400).
  const auto at = [&](double x, double y) {
    return NearestClass(bgr.at<cv::Vec3b>(static_cast<int>(400 - 72 * (y - 5)),
                                          static_cast<int>(640 + 72 * (x - 5))));
  };
  EXPECT_EQ(at(4.7, 5), CoverageClass::kUncovered);
  EXPECT_EQ(at(5.3, 5), CoverageClass::kCovered);
  EXPECT_EQ(at(4.7, 8.3), CoverageClass::kIgnored);
  EXPECT_EQ(at(9.5, 0.5), CoverageClass::kCovered);
  EXPECT_EQ(at(2.5, 7.7), CoverageClass::kUncovered);
}

INSTANTIATE_TEST_SUITE_P(FaceSizes, CoveragePictureTest, ::testing::Values(1, 7, 150));

TEST(FocusOf, IsWhatHasToBeCovered) {
  const std::vector<Eigen::Vector3d> focus = FocusOf(HalfCovered(), Ground(3));
  ASSERT_FALSE(focus.empty());
  for (const Eigen::Vector3d& point : focus) EXPECT_LT(point.y(), 8);
  EXPECT_FALSE(FocusOf({}, Ground(3)).empty());
}

TEST(RenderCoverageMap, EmptyInputGivesAPicture) {
  EXPECT_EQ(RenderCoverageMap(MeshPainter({}), {}, {}).size(), cv::Size(1280, 800));
  EXPECT_EQ(RenderSurface(MeshPainter({}), {}, {}).size(), cv::Size(1280, 800));
  EXPECT_EQ(RenderFlightPath(MeshPainter({}), {}, {}).size(), cv::Size(1280, 800));
}

TEST(RenderSurface, HasTheColoursOfThePhotos) {
  Surface surface;
  surface.mesh = Ground(4);
  surface.color.assign(surface.mesh.vertices.size(), Eigen::Vector3d(0.1, 0.8, 0.1));
  const MeshPainter painter(surface.mesh);
  const cv::Vec3b color =
      RenderSurface(painter, surface, FromAbove(surface.mesh)).at<cv::Vec3b>(400, 640);
  EXPECT_GT(color[1], 4 * color[0]);
  EXPECT_GT(color[1], 4 * color[2]);
}

TEST(RenderFlightPath, ShowsPathAndNumberedViews) {
  const TriangleMesh mesh = Ground(2);
  FlightPicture flight;
  flight.planned_camera = {640, 368, 500, 500, 320, 184};
  flight.views = {{7, {2, 2, 1}, {0, -0.3}, 1.0},
                  {9, {8, 2, 1}, {0, -0.3}, 1.0},
                  {3, {8, 8, 1}, {0, -0.3}, 1.0}};
  flight.path.waypoints = {{{5, 5, 1}, {}, -1}, {{8, 2, 1}, {}, 9}, {{2, 2, 1}, {}, 7}};
  flight.path.dropped_view_ids = {3};
  PictureView view = FromAbove(mesh);
  view.focus.push_back({5, 5, 1});
  const MeshPainter painter(mesh);
  const cv::Mat with = RenderFlightPath(painter, flight, view);
  flight.path = {};
  flight.views.clear();
  const cv::Mat without = RenderFlightPath(painter, flight, view);
  cv::Mat changed;
  cv::absdiff(with, without, changed);
  const auto changes_near = [&](double x, double y) {
    const cv::Rect around(static_cast<int>(640 + 72 * (x - 5)) - 15,
                          static_cast<int>(400 - 72 * (y - 5)) - 15, 30, 30);
    return cv::countNonZero(changed(around).reshape(1) > 30);
  };
  EXPECT_GT(changes_near(5, 5), 50);    // start
  EXPECT_GT(changes_near(5, 2), 50);    // the path from view 1 to view 2
  EXPECT_GT(changes_near(8, 2.1), 50);  // views, the dropped one included
  EXPECT_GT(changes_near(2, 2.1), 50);
  EXPECT_GT(changes_near(8, 8.3), 20);
  EXPECT_EQ(changes_near(2.5, 8), 0);
}

// Two triangles of one superpixel and one of another over a 40 x 20 photo.
ViewMesh SmallViewMesh() {
  ViewMesh mesh;
  mesh.image.vertices_px = {{0, 0}, {20, 0}, {20, 20}, {0, 20}, {40, 0}, {40, 20}};
  mesh.image.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  mesh.image.neighbors = {{3, 1, -1}, {-1, -1, 0}, {-1, 3, -1}, {-1, 0, 2}};
  mesh.image.superpixel = {0, 0, 1, 1};
  mesh.image.num_superpixels = 2;
  mesh.confidence = {1.0f, 1.0f, 0.0f, 0.5f};
  mesh.supported = {1, 1, 1, 0};
  return mesh;
}

TEST(DrawSuperpixels, OutlinesAreStrongerThanInnerEdges) {
  const cv::Mat photo(20, 40, CV_8UC3, cv::Scalar::all(100));
  const cv::Mat picture = DrawSuperpixels(photo, SmallViewMesh().image, 400);
  ASSERT_EQ(picture.size(), cv::Size(400, 200));
  const auto brightest_in_row = [&](int y, int x_begin, int x_end) {
    int brightest = 0;
    for (int x = x_begin; x < x_end; ++x) {
      brightest = std::max<int>(brightest, picture.at<cv::Vec3b>(y, x)[2]);
    }
    return brightest;
  };
  EXPECT_GT(brightest_in_row(50, 190, 210), 170);  // between the superpixels: x = 20 of 40
  const int inner = brightest_in_row(50, 40, 60);  // the diagonal of the first one
  EXPECT_GT(inner, 110);
  EXPECT_LT(inner, 150);
  EXPECT_EQ(brightest_in_row(50, 100, 150), 100);  // no edge
  EXPECT_THROW(DrawSuperpixels(cv::Mat(), SmallViewMesh().image), Error);
}

TEST(DrawConfidence, BrightIsSureAndGreyIsUnsupported) {
  const cv::Mat photo(200, 400, CV_8UC3, cv::Scalar::all(100));
  ViewMesh mesh = SmallViewMesh();
  for (auto& vertex : mesh.image.vertices_px) vertex *= 10;
  const cv::Mat picture = DrawConfidence(photo, mesh, 1280);
  const cv::Vec3b sure = picture.at<cv::Vec3b>(100, 480);         // triangle 0
  const cv::Vec3b unsure = picture.at<cv::Vec3b>(100, 1150);      // triangle 2
  const cv::Vec3b unsupported = picture.at<cv::Vec3b>(560, 800);  // triangle 3
  EXPECT_GT(sure[2], unsure[2] + 80);
  EXPECT_GT(sure[1], unsure[1] + 80);
  EXPECT_EQ(unsupported[0], unsupported[1]);
  EXPECT_EQ(unsupported[1], unsupported[2]);
  mesh.confidence.pop_back();
  EXPECT_THROW(DrawConfidence(photo, mesh), Error);
}

}  // namespace
}  // namespace colmap_ext
