#include "colmap_ext/mvs/superpixels.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "colmap_ext/util/error.h"
#include "mvs/raster.h"
#include "mvs/superpixel_sites.h"
#include "mvs/voronoi_mesh.h"

namespace colmap_ext {
namespace {

void RequireColorPhoto(const cv::Mat& bgr) {
  if (bgr.empty()) throw Error("superpixels: the photo is empty");
  if (bgr.type() != CV_8UC3) throw Error("superpixels: the photo is not 8-bit BGR");
}

// Mean colour of each superpixel over the pixels whose centres it covers (or its first triangle's
// centroid, when it covers none), given to each of its triangles.
void FillMeanColors(const cv::Mat& bgr, ImageMesh* mesh) {
  struct Sum {
    double b = 0, g = 0, r = 0, count = 0;
    void Add(const cv::Vec3b& pixel) {
      b += pixel[0];
      g += pixel[1];
      r += pixel[2];
      count += 1;
    }
  };
  std::vector<Sum> sums(static_cast<std::size_t>(mesh->num_superpixels));
  const auto sum_of = [&](std::size_t t) -> Sum& {
    return sums[static_cast<std::size_t>(mesh->superpixel[t])];
  };
  const cv::Mat1i ids = RasterizeTriangleIds(*mesh, bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      if (ids(y, x) >= 0) {
        sum_of(static_cast<std::size_t>(ids(y, x))).Add(bgr.at<cv::Vec3b>(y, x));
      }
    }
  }
  mesh->mean_bgr.resize(mesh->triangles.size());
  for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
    Sum& sum = sum_of(t);
    if (sum.count == 0) {
      Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
      for (int k = 0; k < 3; ++k) {
        centroid += mesh->vertices_px[static_cast<std::size_t>(mesh->triangles[t][k])] / 3.0;
      }
      sum.Add(bgr.at<cv::Vec3b>(std::clamp(static_cast<int>(centroid.y()), 0, bgr.rows - 1),
                                std::clamp(static_cast<int>(centroid.x()), 0, bgr.cols - 1)));
    }
    mesh->mean_bgr[t] =
        Eigen::Vector3d(sum.b / sum.count, sum.g / sum.count, sum.r / sum.count).cast<float>();
  }
}

// Joins `piece` to `line` when it continues or repeats it.
bool Absorb(const LineSegment& piece, LineSegment* line) {
  constexpr double kMaxSine = 0.07;
  constexpr double kMaxAcrossPx = 1.2;
  constexpr double kMaxGapPx = 5.0;
  const double length = line->Length();
  const Eigen::Vector2d along = (line->end_px - line->start_px) / length;
  const auto across = [&](const Eigen::Vector2d& v) {
    return along.x() * v.y() - along.y() * v.x();
  };
  const Eigen::Vector2d a = piece.start_px - line->start_px;
  const Eigen::Vector2d b = piece.end_px - line->start_px;
  if (std::abs(across(b - a)) > kMaxSine * piece.Length()) return false;
  if (std::max(std::abs(across(a)), std::abs(across(b))) > kMaxAcrossPx) return false;
  const double low = std::min(along.dot(a), along.dot(b));
  const double high = std::max(along.dot(a), along.dot(b));
  if (low > length + kMaxGapPx || high < -kMaxGapPx) return false;
  const Eigen::Vector2d start = line->start_px;
  line->start_px = start + std::min(0.0, low) * along;
  line->end_px = start + std::max(length, high) * along;
  return true;
}

void SortByLength(std::vector<LineSegment>* segments) {
  std::stable_sort(
      segments->begin(), segments->end(),
      [](const LineSegment& a, const LineSegment& b) { return a.Length() > b.Length(); });
}

// Pieces of one line become one segment; those of at least `min_length`, longest first.
std::vector<LineSegment> Consolidate(std::vector<LineSegment> pieces, double min_length) {
  SortByLength(&pieces);
  std::vector<LineSegment> lines;
  for (const LineSegment& piece : pieces) {
    const bool absorbed = std::any_of(lines.begin(), lines.end(),
                                      [&](LineSegment& line) { return Absorb(piece, &line); });
    if (!absorbed) lines.push_back(piece);
  }
  lines.erase(std::remove_if(lines.begin(), lines.end(),
                             [&](const LineSegment& line) { return line.Length() < min_length; }),
              lines.end());
  SortByLength(&lines);
  return lines;
}

// In rows of tiles, to and fro: sites near each other get near numbers, and so do their triangles,
// so that what later stages look up together lies together in memory.
std::vector<Eigen::Vector2d> InTiles(std::vector<Eigen::Vector2d> sites_px) {
  constexpr double kTilePx = 32.0;
  const auto key = [](const Eigen::Vector2d& p) {
    const int row = static_cast<int>(p.y() / kTilePx);
    const int column = static_cast<int>(p.x() / kTilePx);
    return std::make_tuple(row, row % 2 == 0 ? column : -column, p.y(), p.x());
  };
  std::sort(sites_px.begin(), sites_px.end(),
            [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return key(a) < key(b); });
  return sites_px;
}

}  // namespace

std::vector<LineSegment> DetectLineSegments(const cv::Mat& bgr, const SuperpixelOptions& options) {
  RequireColorPhoto(bgr);
  ThrowIfInvalid(options.Check());
  std::vector<LineSegment> segments;
  // The detector's gradient needs a few pixels.
  if (std::min(bgr.cols, bgr.rows) * options.lsd_scale < 8) return segments;
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::Vec4f> lines;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD, options.lsd_scale)->detect(gray, lines);
  const Eigen::AlignedBox2d image(Eigen::Vector2d::Zero(), Eigen::Vector2d(bgr.cols, bgr.rows));
  for (const cv::Vec4f& line : lines) {
    // OpenCV's pixel centres are whole numbers, ours end in .5.
    const Eigen::Vector2d half(0.5, 0.5);
    const Eigen::Vector2d start = Eigen::Vector2d(line[0], line[1]) + half;
    const Eigen::Vector2d end = Eigen::Vector2d(line[2], line[3]) + half;
    const LineSegment segment{start.cwiseMax(image.min()).cwiseMin(image.max()),
                              end.cwiseMax(image.min()).cwiseMin(image.max())};
    if (segment.Length() >= 0.5 * options.min_segment_px) segments.push_back(segment);
  }
  return Consolidate(std::move(segments), options.min_segment_px);
}

ImageMesh SegmentPhoto(const cv::Mat& bgr, const SuperpixelOptions& options) {
  const std::vector<LineSegment> segments = DetectLineSegments(bgr, options);
  const SuperpixelSites sites = PlaceSites(segments, bgr.cols, bgr.rows, options);
  ImageMesh mesh = BuildVoronoiMesh(InTiles(sites.points_px), bgr.cols, bgr.rows,
                                    sites.cover_radius_px, options.merge_px);
  FillMeanColors(bgr, &mesh);
  return mesh;
}

}  // namespace colmap_ext
