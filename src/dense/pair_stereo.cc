#include "colmap_ext/dense/pair_stereo.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/dense/epipolar_frame.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr float kNone = -1e9F;
constexpr int kMaxSearchPx = 1024;
// Steps of the prior above this share of its value are edges, not slants.
constexpr double kPriorStep = 0.02;
// Steps of disparity between neighbouring pixels above this are edges.
constexpr float kDisparityStepPx = 1.5F;
// Directions nearer than this to the baseline have no parallax to speak of.
constexpr double kMaxSlope = 8;

// The part of the epipolar plane that is matched.
struct Window {
  int col0 = 0, row0 = 0;  // epipolar position of the centre of the upper left pixel
  int width = 0, height = 0;
};

Window WindowOf(const EpipolarFrame& frame, int margin_px) {
  Window window;
  window.col0 = static_cast<int>(std::floor(frame.min_position().x())) - margin_px;
  window.row0 = static_cast<int>(std::floor(frame.min_position().y()));
  window.width = static_cast<int>(std::ceil(frame.max_position().x())) + margin_px - window.col0;
  window.height = static_cast<int>(std::ceil(frame.max_position().y())) - window.row0;
  return window;
}

// Search of one pair: disparities in [offset - half, offset + half) around the prior.
struct Disparities {
  double offset = 0;  // without a prior; columns
  int half = 0;       // multiple of 8
};

Disparities FullSearch(const EpipolarFrame& frame, const DepthRange& range) {
  const double parallax = frame.focal_px() * frame.baseline();
  // Along the baseline there is less parallax, down to none.
  const double low = frame.is_planar() ? parallax / range.max : 0;
  const double high = parallax / range.min;
  Disparities disparities;
  disparities.offset = std::round(0.5 * (low + high));
  const int half = static_cast<int>(std::ceil(0.5 * (high - low))) + 4;
  disparities.half = std::min(kMaxSearchPx, (half + 7) / 8 * 8);
  return disparities;
}

class PairMatcher {
 public:
  PairMatcher(const StereoView& reference, const StereoView& partner, const StereoSearch& search,
              const DenseStereoOptions& options)
      : reference_(reference),
        partner_(partner),
        search_(search),
        options_(options),
        frame_(reference.camera, reference.cam_from_world, partner.cam_from_world) {
    if (search.inverse_depth.empty()) {
      disparities_ = FullSearch(frame_, search.range);
    } else {
      disparities_.half = options.residual_px;
    }
    window_ = WindowOf(frame_, disparities_.half);
  }

  PairDepth Run() {
    PairDepth depth;
    depth.inverse_depth = cv::Mat::zeros(reference_.camera.height, reference_.camera.width, CV_32F);
    depth.per_pixel = depth.inverse_depth.clone();
    const int size_limit = 8 * std::max(reference_.camera.width, reference_.camera.height);
    if (window_.height < 3 || window_.width - 4 * disparities_.half < 3 ||
        window_.width - 2 * disparities_.half > size_limit || window_.height > size_limit) {
      return depth;  // nothing in common, or a photo that looks straight along the baseline
    }
    Warp();
    Match();
    Triangulate(&depth);
    return depth;
  }

 private:
  double PriorColumn(double col, double row, double slope, const Eigen::Vector3d& in_reference,
                     double rho, double u, double v) const {
    if (search_.inverse_depth.empty()) return col - disparities_.offset;
    const double scale_u =
        search_.inverse_depth.cols / static_cast<double>(reference_.camera.width);
    const double scale_v =
        search_.inverse_depth.rows / static_cast<double>(reference_.camera.height);
    const float prior =
        SampleSmooth(search_.inverse_depth, u * scale_u - 0.5, v * scale_v - 0.5, kPriorStep);
    if (!(prior > 0)) return kNone;
    // rho belongs to the direction scaled to z = 1 in the reference camera.
    const double inverse_rho = prior * in_reference.z() / rho;
    return frame_.Column(slope - frame_.baseline() * inverse_rho, row);
  }

  void WarpPixel(int x, int y, cv::Vec2f* left, cv::Vec2f* right, float* partner_col) const {
    *left = *right = cv::Vec2f(-9, -9);
    *partner_col = kNone;
    const double col = window_.col0 + x;
    const double row = window_.row0 + y;
    const double slope = frame_.Slope(col, row);
    if (std::abs(slope) > kMaxSlope) return;
    const Eigen::Vector3d direction = frame_.Direction(col, row);
    const Eigen::Vector3d in_reference = frame_.ToReference(direction);
    if (!(in_reference.z() > 0)) return;
    const Eigen::Vector2d pixel = reference_.camera.Project(in_reference);
    *left = cv::Vec2f(static_cast<float>(pixel.x() - 0.5), static_cast<float>(pixel.y() - 0.5));
    const double rho = std::hypot(direction.y(), direction.z());
    // Beyond the border the photo's edge stands for the prior, so that the search has its margin.
    const double u = std::clamp(pixel.x(), 0.5, reference_.camera.width - 0.5);
    const double v = std::clamp(pixel.y(), 0.5, reference_.camera.height - 0.5);
    const double column = PriorColumn(col, row, slope, in_reference, rho, u, v);
    if (column == kNone) return;
    const Eigen::Vector3d in_partner = frame_.ToPartner(frame_.Direction(column, row));
    if (!(in_partner.z() > 0)) return;
    const Eigen::Vector2d target = partner_.camera.Project(in_partner);
    if (!partner_.camera.Contains(target, 0.5)) return;
    *right = cv::Vec2f(static_cast<float>(target.x() - 0.5), static_cast<float>(target.y() - 0.5));
    *partner_col = static_cast<float>(column);
  }

  void Warp() {
    cv::Mat left_map(window_.height, window_.width, CV_32FC2);
    cv::Mat right_map(window_.height, window_.width, CV_32FC2);
    partner_col_.create(window_.height, window_.width, CV_32F);
    ParallelFor(window_.height, [&](int y) {
      for (int x = 0; x < window_.width; ++x) {
        WarpPixel(x, y, &left_map.at<cv::Vec2f>(y, x), &right_map.at<cv::Vec2f>(y, x),
                  &partner_col_.at<float>(y, x));
      }
    });
    cv::remap(reference_.gray, left_, left_map, cv::noArray(), cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
    cv::remap(partner_.gray, right_, right_map, cv::noArray(), cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
  }

  void Match() {
    const int area = options_.block_px * options_.block_px;
    constexpr int kSpeckleShare = 5000;
    const int speckle_px = std::max(20, window_.width * window_.height / kSpeckleShare);
    const cv::Ptr<cv::StereoSGBM> matcher = cv::StereoSGBM::create(
        -disparities_.half, 2 * disparities_.half, options_.block_px, 8 * area, 32 * area,
        /*disp12MaxDiff=*/1, /*preFilterCap=*/31, options_.uniqueness_percent, speckle_px,
        /*speckleRange=*/1, cv::StereoSGBM::MODE_SGBM_3WAY);
    matcher->compute(left_, right_, disparity_);
  }

  // Disparity (reference column less partner column) of the match at a pixel of the window.
  float DisparityAt(int x, int y) const {
    const short raw = disparity_.at<short>(y, x);
    if (raw < -16 * disparities_.half) return kNone;
    const float matched = static_cast<float>(x) - static_cast<float>(raw) / 16.0F;
    const int x0 = static_cast<int>(std::floor(matched));
    if (x0 < 0 || x0 + 1 >= window_.width) return kNone;
    const float a = partner_col_.at<float>(y, x0);
    const float b = partner_col_.at<float>(y, x0 + 1);
    if (a == kNone || b == kNone) return kNone;
    const float share = matched - static_cast<float>(x0);
    // Neighbouring columns of a steep or broken prior do not belong together.
    const float column =
        std::abs(b - a - 1) > kDisparityStepPx ? (share < 0.5F ? a : b) : a + share * (b - a);
    return static_cast<float>(window_.col0 + x) - column;
  }

  // Bilinear over disparities; kNone at edges and holes.
  double DisparityAtPosition(const cv::Mat& disparity, double x, double y) const {
    const int x0 = static_cast<int>(std::floor(x));
    const int y0 = static_cast<int>(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 + 1 >= window_.width || y0 + 1 >= window_.height) return kNone;
    const float a = disparity.at<float>(y0, x0), b = disparity.at<float>(y0, x0 + 1);
    const float c = disparity.at<float>(y0 + 1, x0), d = disparity.at<float>(y0 + 1, x0 + 1);
    const float low = std::min({a, b, c, d});
    if (low == kNone || std::max({a, b, c, d}) - low > kDisparityStepPx) return kNone;
    const double s = x - x0, t = y - y0;
    return (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d);
  }

  void TriangulatePixel(const cv::Mat& disparity, int u, int v, PairDepth* depth) const {
    const Eigen::Vector3d ray = frame_.FromReference(reference_.camera.Ray({u + 0.5, v + 0.5}));
    if (frame_.is_planar() && !(ray.z() > 0)) return;
    const Eigen::Vector2d position = frame_.Position(ray);
    const double found =
        DisparityAtPosition(disparity, position.x() - window_.col0, position.y() - window_.row0);
    if (found == kNone) return;
    const double column = position.x() - found;
    const double slope = frame_.Slope(position.x(), position.y());
    const double partner_slope = frame_.Slope(column, position.y());
    const double scale = std::hypot(ray.y(), ray.z()) / frame_.baseline();
    const double inverse_depth = scale * (slope - partner_slope);
    if (!(inverse_depth * search_.range.max > 0.5 && inverse_depth * search_.range.min < 2)) return;
    const double step = partner_slope - frame_.Slope(column - 1, position.y());
    depth->inverse_depth.at<float>(v, u) = static_cast<float>(inverse_depth);
    depth->per_pixel.at<float>(v, u) = static_cast<float>(scale * step);
  }

  void Triangulate(PairDepth* depth) const {
    cv::Mat disparity(window_.height, window_.width, CV_32F);
    ParallelFor(window_.height, [&](int y) {
      for (int x = 0; x < window_.width; ++x) disparity.at<float>(y, x) = DisparityAt(x, y);
    });
    ParallelFor(reference_.camera.height, [&](int v) {
      for (int u = 0; u < reference_.camera.width; ++u) TriangulatePixel(disparity, u, v, depth);
    });
  }

  const StereoView& reference_;
  const StereoView& partner_;
  const StereoSearch& search_;
  const DenseStereoOptions& options_;
  EpipolarFrame frame_;
  Disparities disparities_;
  Window window_;
  cv::Mat partner_col_;  // CV_32F: column of the partner that right_ shows there, or kNone
  cv::Mat left_, right_;
  cv::Mat disparity_;  // CV_16S, in sixteenths, between left_ and right_
};

}  // namespace

float SampleSmooth(const cv::Mat& map, double col, double row, double max_step) {
  const int x = static_cast<int>(std::lround(col));
  const int y = static_cast<int>(std::lround(row));
  if (x < 0 || y < 0 || x >= map.cols || y >= map.rows) return 0;
  const float nearest = map.at<float>(y, x);
  const int x0 = static_cast<int>(std::floor(col));
  const int y0 = static_cast<int>(std::floor(row));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= map.cols || y0 + 1 >= map.rows) return nearest;
  const float a = map.at<float>(y0, x0), b = map.at<float>(y0, x0 + 1);
  const float c = map.at<float>(y0 + 1, x0), d = map.at<float>(y0 + 1, x0 + 1);
  const float low = std::min({a, b, c, d}), high = std::max({a, b, c, d});
  if (!(low > 0) || high - low > max_step * high) return nearest;
  const double s = col - x0, t = row - y0;
  return static_cast<float>((1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d));
}

PairDepth MatchPair(const StereoView& reference, const StereoView& partner,
                    const StereoSearch& search, const DenseStereoOptions& options) {
  return PairMatcher(reference, partner, search, options).Run();
}

}  // namespace colmap_ext
