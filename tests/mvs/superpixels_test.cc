#include "colmap_ext/mvs/superpixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "colmap_ext/util/error.h"
#include "mvs/raster.h"
#include "mvs/superpixel_sites.h"
#include "mvs/voronoi_mesh.h"

namespace colmap_ext {
namespace {

double AreaOf(const ImageMesh& mesh, std::size_t t) {
  const auto corner = [&](int k) {
    return mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][k])];
  };
  return 0.5 * Cross(corner(0), corner(1), corner(2));
}

// Everything that every partition must fulfil.
void ExpectExactCover(const ImageMesh& mesh, int width, int height) {
  const std::size_t n = mesh.triangles.size();
  ASSERT_GT(n, 0u);
  ASSERT_EQ(mesh.neighbors.size(), n);
  ASSERT_EQ(mesh.superpixel.size(), n);
  double area = 0;
  double border = 0;
  for (std::size_t t = 0; t < n; ++t) {
    EXPECT_GE(AreaOf(mesh, t), 0.05);
    area += AreaOf(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][(k + 1) % 3];
      const int b = mesh.triangles[t][(k + 2) % 3];
      const Eigen::Vector2d& p = mesh.vertices_px[static_cast<std::size_t>(a)];
      const Eigen::Vector2d& q = mesh.vertices_px[static_cast<std::size_t>(b)];
      const int other = mesh.neighbors[t][k];
      if (other < 0) {
        border += (p - q).norm();
        const bool vertical = p.x() == q.x() && (p.x() == 0 || p.x() == width);
        const bool horizontal = p.y() == q.y() && (p.y() == 0 || p.y() == height);
        EXPECT_TRUE(vertical || horizontal) << p.transpose() << " - " << q.transpose();
        continue;
      }
      const Eigen::Vector3i& back = mesh.triangles[static_cast<std::size_t>(other)];
      const std::set<int> corners(back.data(), back.data() + 3);
      EXPECT_TRUE(corners.count(a) == 1 && corners.count(b) == 1);
      const Eigen::Vector3i& links = mesh.neighbors[static_cast<std::size_t>(other)];
      EXPECT_EQ(std::count(links.data(), links.data() + 3, static_cast<int>(t)), 1);
    }
  }
  EXPECT_NEAR(area, static_cast<double>(width) * height, 1e-6 * width * height);
  EXPECT_NEAR(border, 2.0 * (width + height), 1e-6 * (width + height));
  const cv::Mat1i ids = RasterizeTriangleIds(mesh, width, height);
  EXPECT_EQ(cv::countNonZero(ids < 0), 0);
  EXPECT_TRUE(std::is_sorted(mesh.superpixel.begin(), mesh.superpixel.end()));
  EXPECT_EQ(mesh.superpixel.front(), 0);
  EXPECT_EQ(mesh.superpixel.back(), mesh.num_superpixels - 1);
}

// A photo of filled polygons with straight edges, drawn with anti-aliasing.
cv::Mat PolygonPhoto(int width, int height, std::uint32_t seed) {
  cv::Mat photo(height, width, CV_8UC3, cv::Scalar(90, 120, 100));
  std::mt19937 random(seed);
  const auto number = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<std::uint32_t>(high - low + 1));
  };
  for (int i = 0; i < 8; ++i) {
    const cv::Point center(number(0, width), number(0, height));
    std::vector<cv::Point> corners;
    for (int k = 0; k < 4; ++k) {
      const double angle = 1.5708 * k + 0.1 * number(0, 10);
      const double radius = number(40, 110);
      corners.emplace_back(center.x + static_cast<int>(radius * std::cos(angle)),
                           center.y + static_cast<int>(radius * std::sin(angle)));
    }
    cv::fillConvexPoly(photo, corners, cv::Scalar(number(0, 255), number(0, 255), number(0, 255)),
                       cv::LINE_AA);
  }
  cv::GaussianBlur(photo, photo, {}, 0.7);
  return photo;
}

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - s * (b - a)).norm();
}

// Share of the segments' points (one a pixel) with a polygon edge of nearly the same direction
// within `tolerance_px`.
double FollowedShare(const ImageMesh& mesh, const std::vector<LineSegment>& segments,
                     double tolerance_px) {
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int other = mesh.neighbors[t][k];
      if (other <= static_cast<int>(t)) continue;
      if (mesh.superpixel[static_cast<std::size_t>(other)] == mesh.superpixel[t]) continue;
      edges.emplace_back(
          mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][(k + 1) % 3])],
          mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][(k + 2) % 3])]);
    }
  }
  int points = 0;
  int followed = 0;
  for (const LineSegment& segment : segments) {
    const Eigen::Vector2d along = (segment.end_px - segment.start_px).normalized();
    for (double s = 0.5; s < segment.Length(); s += 1.0) {
      const Eigen::Vector2d p = segment.start_px + s * along;
      ++points;
      followed += std::any_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const Eigen::Vector2d direction = (edge.second - edge.first).normalized();
        return std::abs(direction.dot(along)) > 0.9 &&
               DistanceToSegment(p, edge.first, edge.second) <= tolerance_px;
      });
    }
  }
  return points == 0 ? 1.0 : static_cast<double>(followed) / points;
}

TEST(Superpixels, CoverThePhotoExactly) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const cv::Mat photo = PolygonPhoto(320, 240, seed);
    ExpectExactCover(SegmentPhoto(photo, {}), 320, 240);
  }
}

TEST(Superpixels, CoverPhotosOfAnySizeAndContent) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 40), cv::Size(9, 9), cv::Size(101, 37)}) {
    ExpectExactCover(SegmentPhoto(cv::Mat(size, CV_8UC3, cv::Scalar(0, 0, 0)), {}), size.width,
                     size.height);
    cv::Mat noise(size, CV_8UC3);
    cv::RNG(5).fill(noise, cv::RNG::UNIFORM, 0, 256);
    ExpectExactCover(SegmentPhoto(noise, {}), size.width, size.height);
  }
}

TEST(Superpixels, AreAboutAsManyAsWanted) {
  for (const int target : {300, 1000, 3000}) {
    SuperpixelOptions options;
    options.target_polygons = target;
    const cv::Mat photo = PolygonPhoto(640, 368, 3);
    EXPECT_NEAR(SegmentPhoto(photo, options).num_superpixels, target, 0.2 * target);
    cv::Mat half;
    cv::resize(photo, half, {}, 0.5, 0.5, cv::INTER_AREA);
    EXPECT_NEAR(SegmentPhoto(half, options).num_superpixels, 0.25 * target, 0.08 * target);
  }
}

TEST(Superpixels, FollowLineSegmentsWithinAPixel) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const cv::Mat photo = PolygonPhoto(640, 368, seed);
    SuperpixelOptions options;
    options.min_segment_px = 20;
    const std::vector<LineSegment> segments = DetectLineSegments(photo, options);
    ASSERT_GT(segments.size(), 10u);
    EXPECT_GT(FollowedShare(SegmentPhoto(photo, options), segments, 1.0), 0.9) << seed;
  }
}

TEST(Superpixels, OfRandomCellsDoNotFollowByChance) {
  const cv::Mat photo = PolygonPhoto(640, 368, 1);
  SuperpixelOptions options;
  options.min_segment_px = 20;
  const std::vector<LineSegment> segments = DetectLineSegments(photo, options);
  options.max_anchor_share = 0;
  EXPECT_LT(FollowedShare(SegmentPhoto(photo, options), segments, 1.0), 0.3);
}

TEST(Superpixels, ALoneSegmentIsFollowedAllAlong) {
  SuperpixelOptions options;
  const std::vector<LineSegment> segments{{{60.3, 50.8}, {250.6, 180.2}}};
  const SuperpixelSites sites = PlaceSites(segments, 320, 240, options);
  const ImageMesh mesh =
      BuildVoronoiMesh(sites.points_px, 320, 240, sites.cover_radius_px, options.merge_px);
  ExpectExactCover(mesh, 320, 240);
  EXPECT_EQ(FollowedShare(mesh, segments, 1.0), 1.0);
}

TEST(Superpixels, ArePolygonsWithTheMeanColorOfTheirPixels) {
  cv::Mat photo(120, 160, CV_8UC3, cv::Scalar(10, 20, 30));
  photo(cv::Rect(80, 0, 80, 120)).setTo(cv::Scalar(200, 150, 100));
  const ImageMesh mesh = SegmentPhoto(photo, {});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double x = mesh.vertices_px[static_cast<std::size_t>(mesh.triangles[t][0])].x();
    if (x >= 60 && x <= 100) continue;
    const Eigen::Vector3f truth =
        x < 60 ? Eigen::Vector3f(10, 20, 30) : Eigen::Vector3f(200, 150, 100);
    EXPECT_LT((mesh.mean_bgr[t] - truth).norm(), 1e-3);
  }
}

TEST(Superpixels, AreTheSameEveryTime) {
  const cv::Mat photo = PolygonPhoto(320, 240, 9);
  const ImageMesh a = SegmentPhoto(photo, {});
  const ImageMesh b = SegmentPhoto(photo, {});
  EXPECT_EQ(a.vertices_px, b.vertices_px);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(Superpixels, DelaunayDegeneraciesDoNotBreakTheCover) {
  // A square grid of sites: every Voronoi vertex belongs to four cells.
  std::vector<Eigen::Vector2d> sites;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 10; ++x) sites.emplace_back(5 + 10 * x, 5 + 10 * y);
  }
  const ImageMesh mesh = BuildVoronoiMesh(sites, 100, 80, 20, 1.5);
  ExpectExactCover(mesh, 100, 80);
  EXPECT_EQ(mesh.num_superpixels, 80);
  EXPECT_EQ(mesh.triangles.size(), 160u);
}

TEST(Superpixels, BadInputIsRefused) {
  EXPECT_THROW(SegmentPhoto(cv::Mat(), {}), Error);
  EXPECT_THROW(SegmentPhoto(cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)), {}), Error);
  SuperpixelOptions options;
  options.merge_px = 40;
  EXPECT_THROW(SegmentPhoto(cv::Mat(10, 10, CV_8UC3, cv::Scalar(0, 0, 0)), options), UsageError);
  EXPECT_NE(options.Check().find("merge_px"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
