#include "mvs/superpixel_sites.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <random>

namespace colmap_ext {
namespace {

constexpr double kLongestSpacing = 2.0;  // of anchor pairs, in units of anchor_spacing_px

// Two anchors facing each other across a segment, responsible for `half_length` to either side.
struct AnchorPair {
  Eigen::Vector2d center;
  Eigen::Vector2d along;  // unit
  double half_length = 0;
  double offset = 0;
  std::size_t segment = 0;

  Eigen::Vector2d Anchor(int side) const {
    const Eigen::Vector2d across(-along.y(), along.x());
    return center + (side == 0 ? offset : -offset) * across;
  }
  // The bisector of the pair is the segment. A foreign site at distance b along and h across comes
  // nearer to some point of the pair's stretch than the pair itself when h² < offset² + b (s - b),
  // s = 2 half_length: it would bend the boundary away from the segment.
  bool IsBentBy(const Eigen::Vector2d& site) const {
    const Eigen::Vector2d to_site = site - center;
    const double b = std::abs(along.dot(to_site));
    const double across_sq = to_site.squaredNorm() - b * b;
    return across_sq < offset * offset + b * (2 * half_length - b) - 1e-9;
  }
  double Reach() const { return 2 * half_length + offset; }
};

// Buckets of pairs, to find those near a point.
class PairGrid {
 public:
  PairGrid(int width, int height, double cell)
      : cell_(cell),
        columns_(static_cast<int>(width / cell) + 1),
        rows_(static_cast<int>(height / cell) + 1),
        buckets_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  void Add(const AnchorPair& pair) { buckets_[Bucket(pair.center, 0, 0)].push_back(pair); }

  // Whether any pair within one cell of `center` satisfies `test`.
  template <typename Test>
  bool AnyNear(const Eigen::Vector2d& center, const Test& test) const {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!HasBucket(center, dx, dy)) continue;
        const auto& bucket = buckets_[Bucket(center, dx, dy)];
        if (std::any_of(bucket.begin(), bucket.end(), test)) return true;
      }
    }
    return false;
  }

 private:
  int Column(const Eigen::Vector2d& p) const { return static_cast<int>(p.x() / cell_); }
  int Row(const Eigen::Vector2d& p) const { return static_cast<int>(p.y() / cell_); }
  bool HasBucket(const Eigen::Vector2d& p, int dx, int dy) const {
    const int column = Column(p) + dx;
    const int row = Row(p) + dy;
    return column >= 0 && row >= 0 && column < columns_ && row < rows_;
  }
  std::size_t Bucket(const Eigen::Vector2d& p, int dx, int dy) const {
    return static_cast<std::size_t>(Row(p) + dy) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(Column(p) + dx);
  }

  double cell_;
  int columns_;
  int rows_;
  std::vector<std::vector<AnchorPair>> buckets_;
};

bool Conflict(const AnchorPair& a, const AnchorPair& b) {
  if (a.segment == b.segment) return false;
  for (int side = 0; side < 2; ++side) {
    if (a.IsBentBy(b.Anchor(side)) || b.IsBentBy(a.Anchor(side))) return true;
    for (int other = 0; other < 2; ++other) {
      if ((a.Anchor(side) - b.Anchor(other)).squaredNorm() < 1.0) return true;
    }
  }
  return false;
}

bool IsInside(const Eigen::Vector2d& p, int width, int height) {
  constexpr double kMargin = 0.5;
  return p.x() >= kMargin && p.y() >= kMargin && p.x() <= width - kMargin &&
         p.y() <= height - kMargin;
}

// Places pairs along segments, the longest segments first. Where a pair would bend a boundary that
// is there, or be bent by it, as at junctions and beside near parallels, its stretch is halved:
// shorter stretches with nearer anchors need less room.
class AnchorPlacer {
 public:
  AnchorPlacer(int width, int height, double spacing, std::size_t max_pairs,
               const SuperpixelOptions& options)
      : width_(width),
        height_(height),
        spacing_(spacing),
        max_pairs_(max_pairs),
        options_(options),
        grid_(width, height, 2 * (spacing + options.anchor_offset_px)) {}

  void Place(const LineSegment& segment, std::size_t index) {
    const double length = segment.Length();
    const int count = std::max(1, static_cast<int>(std::lround(length / spacing_)));
    AnchorPair pair;
    pair.along = (segment.end_px - segment.start_px) / length;
    pair.segment = index;
    const double half_length = 0.5 * length / count;
    for (int k = 0; k < count; ++k) {
      pair.center = segment.start_px + (2 * k + 1) * half_length * pair.along;
      PlaceStretch(pair, half_length);
    }
  }

  std::vector<AnchorPair> TakePairs() { return std::move(accepted_); }

 private:
  void PlaceStretch(AnchorPair pair, double half_length) {
    constexpr double kLeastHalfLengthPx = 1.0;
    constexpr double kLeastOffsetPx = 0.75;
    if (accepted_.size() >= max_pairs_) return;
    pair.half_length = half_length;
    pair.offset = std::min(options_.anchor_offset_px, std::max(kLeastOffsetPx, 0.5 * half_length));
    const auto conflicts = [&](const AnchorPair& other) { return Conflict(pair, other); };
    if (IsInside(pair.Anchor(0), width_, height_) && IsInside(pair.Anchor(1), width_, height_) &&
        !grid_.AnyNear(pair.center, conflicts)) {
      grid_.Add(pair);
      accepted_.push_back(pair);
      return;
    }
    if (half_length < 2 * kLeastHalfLengthPx) return;
    const Eigen::Vector2d center = pair.center;
    for (const double side : {-0.5, 0.5}) {
      pair.center = center + side * half_length * pair.along;
      PlaceStretch(pair, 0.5 * half_length);
    }
  }

  int width_;
  int height_;
  double spacing_;
  std::size_t max_pairs_;
  const SuperpixelOptions& options_;
  PairGrid grid_;
  std::vector<AnchorPair> accepted_;
};

std::vector<AnchorPair> PlaceAnchors(const std::vector<LineSegment>& segments, int width,
                                     int height, std::size_t max_pairs,
                                     const SuperpixelOptions& options) {
  // Pairs lie further apart where there is more to follow than pairs for it.
  constexpr double kExtra = 1.3;  // pairs that halving adds
  double length = 0;
  for (const LineSegment& segment : segments) length += segment.Length();
  const double spacing =
      std::clamp(kExtra * length / std::max(1.0, static_cast<double>(max_pairs)),
                 options.anchor_spacing_px, kLongestSpacing * options.anchor_spacing_px);
  AnchorPlacer placer(width, height, spacing, max_pairs, options);
  for (std::size_t s = 0; s < segments.size(); ++s) placer.Place(segments[s], s);
  return placer.TakePairs();
}

// Pixels where a further site would bend a boundary or crowd an anchor.
cv::Mat1b ForbiddenPixels(const std::vector<AnchorPair>& pairs, int width, int height,
                          double anchor_distance) {
  cv::Mat1b forbidden(height, width, static_cast<std::uint8_t>(0));
  for (const AnchorPair& pair : pairs) {
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector2d anchor = pair.Anchor(side);
      cv::circle(forbidden, {static_cast<int>(anchor.x()), static_cast<int>(anchor.y())},
                 static_cast<int>(std::ceil(anchor_distance)), 1, cv::FILLED);
    }
    const double reach = pair.Reach();
    const int x_end = std::min(width, static_cast<int>(pair.center.x() + reach) + 1);
    const int y_end = std::min(height, static_cast<int>(pair.center.y() + reach) + 1);
    for (int y = std::max(0, static_cast<int>(pair.center.y() - reach)); y < y_end; ++y) {
      for (int x = std::max(0, static_cast<int>(pair.center.x() - reach)); x < x_end; ++x) {
        if (pair.IsBentBy({x + 0.5, y + 0.5})) forbidden(y, x) = 1;
      }
    }
  }
  return forbidden;
}

// Every second pixel's centre in an order that the seed alone decides.
std::vector<cv::Point> ShuffledPixels(int width, int height, std::uint64_t seed) {
  std::vector<cv::Point> pixels;
  for (int y = std::min(1, height - 1); y < height; y += 2) {
    for (int x = std::min(1, width - 1); x < width; x += 2) pixels.emplace_back(x, y);
  }
  std::mt19937_64 random(seed);
  for (std::size_t i = pixels.size(); i > 1; --i) {
    std::swap(pixels[i - 1], pixels[((random() >> 32) * i) >> 32]);
  }
  return pixels;
}

// Poisson-disk sampling of the allowed pixels: none nearer than `radius`, no room for another.
std::vector<Eigen::Vector2d> SampleFlatAreas(const cv::Mat1b& forbidden, double radius,
                                             std::uint64_t seed) {
  const double cell = radius / std::sqrt(2.0);  // at most one sample a cell
  const cv::Size grid_size(static_cast<int>(forbidden.cols / cell) + 1,
                           static_cast<int>(forbidden.rows / cell) + 1);
  cv::Mat1i sample_in_cell(grid_size, -1);
  std::vector<Eigen::Vector2d> samples;
  const auto is_free = [&](const Eigen::Vector2d& p, const cv::Point& c) {
    for (int y = std::max(0, c.y - 2); y <= std::min(grid_size.height - 1, c.y + 2); ++y) {
      for (int x = std::max(0, c.x - 2); x <= std::min(grid_size.width - 1, c.x + 2); ++x) {
        const int s = sample_in_cell(y, x);
        if (s < 0) continue;
        if ((samples[static_cast<std::size_t>(s)] - p).squaredNorm() < radius * radius)
          return false;
      }
    }
    return true;
  };
  for (const cv::Point& pixel : ShuffledPixels(forbidden.cols, forbidden.rows, seed)) {
    if (forbidden(pixel) != 0) continue;
    const Eigen::Vector2d p(pixel.x + 0.5, pixel.y + 0.5);
    const cv::Point c(static_cast<int>(p.x() / cell), static_cast<int>(p.y() / cell));
    if (!is_free(p, c)) continue;
    sample_in_cell(c) = static_cast<int>(samples.size());
    samples.push_back(p);
  }
  return samples;
}

}  // namespace

SuperpixelSites PlaceSites(const std::vector<LineSegment>& segments, int width, int height,
                           const SuperpixelOptions& options) {
  // A maximal Poisson-disk sampling with radius r has about kDensity area / r² samples.
  constexpr double kDensity = 0.72;
  constexpr double kAnchorDistance = 0.7;  // from an anchor, of the Poisson radius
  const double area = static_cast<double>(width) * height;
  const double target = std::max(1.0, options.target_polygons * area / (640.0 * 368.0));
  const double plain_radius = std::sqrt(kDensity * area / target);

  const std::vector<AnchorPair> pairs =
      PlaceAnchors(segments, width, height,
                   static_cast<std::size_t>(0.5 * options.max_anchor_share * target), options);
  const cv::Mat1b forbidden = ForbiddenPixels(pairs, width, height, kAnchorDistance * plain_radius);
  const double free_area = area - cv::countNonZero(forbidden);
  const double wanted = std::max(0.1 * target, target - 2.0 * static_cast<double>(pairs.size()));
  const double radius =
      std::clamp(std::sqrt(kDensity * free_area / wanted), 0.5 * plain_radius, 1.5 * plain_radius);

  SuperpixelSites sites;
  for (const AnchorPair& pair : pairs) {
    sites.points_px.push_back(pair.Anchor(0));
    sites.points_px.push_back(pair.Anchor(1));
  }
  sites.num_anchors = sites.points_px.size();
  for (const Eigen::Vector2d& p : SampleFlatAreas(forbidden, radius, options.seed)) {
    sites.points_px.push_back(p);
  }
  if (sites.points_px.empty()) sites.points_px.emplace_back(0.5 * width, 0.5 * height);
  sites.cover_radius_px = std::max(radius, kAnchorDistance * plain_radius +
                                               2 * kLongestSpacing * options.anchor_spacing_px) +
                          4.0;
  return sites;
}

}  // namespace colmap_ext
