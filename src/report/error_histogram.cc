#include "colmap_ext/report/error_histogram.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "colmap_ext/report/picture_overlay.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

constexpr int kBars = 40;
const Rgb kInk = {0.20f, 0.24f, 0.29f};
const Rgb kFaint = {0.86f, 0.88f, 0.90f};
const Rgb kBar = {0.20f, 0.47f, 0.68f};
const Rgb kBeyond = {0.80f, 0.36f, 0.20f};

cv::Scalar ScalarOf(const Rgb& color) {
  return {255.0 * static_cast<double>(color[2]), 255.0 * static_cast<double>(color[1]),
          255.0 * static_cast<double>(color[0])};
}

// Share of the errors in each bar; the last is what lies beyond.
std::vector<double> BarShares(const std::vector<double>& errors_m, double max_error_m) {
  std::vector<double> shares(kBars + 1, 0.0);
  for (const double error : errors_m) {
    const double position = std::min(error / max_error_m * kBars, static_cast<double>(kBars));
    shares[static_cast<std::size_t>(position)] += 1.0 / static_cast<double>(errors_m.size());
  }
  return shares;
}

// The area between the axes, and what is drawn into it.
class Plot {
 public:
  Plot(const cv::Size& size, double max_error_m, double max_share)
      : picture_(size, CV_8UC3, cv::Scalar::all(255)),
        area_(56, 34, size.width - 56 - 56, size.height - 34 - 44),
        max_error_m_(max_error_m),
        max_share_(max_share) {}

  void DrawGrid() {
    for (int i = 0; i <= 4; ++i) {
      const int y = Y(max_share_ * i / 4);
      cv::line(picture_, {area_.x, y}, {area_.x + area_.width, y}, ScalarOf(kFaint), 1);
      Text(FormatNumber("%.0f %%", 25.0 * i * max_share_), {area_.x - 6.0, 1.0 * y},
           TextAnchor::kRight);
      Text(FormatNumber("%.0f %%", 25.0 * i), {area_.x + area_.width + 6.0, 1.0 * y},
           TextAnchor::kLeft);
      const double error_m = max_error_m_ * i / 4;
      Text(FormatNumber("%.0f mm", 1000 * error_m), {X(error_m), area_.br().y + 14.0},
           TextAnchor::kCenter);
    }
    Text("bars: share of the samples by error; line: share below; last bar: beyond",
         {1.0 * area_.x, area_.br().y + 32.0}, TextAnchor::kLeft);
  }

  void DrawBars(const std::vector<double>& shares) {
    for (int i = 0; i <= kBars; ++i) {
      if (shares[static_cast<std::size_t>(i)] <= 0) continue;
      const auto left = static_cast<int>(X(max_error_m_ * i / kBars));
      const auto right = static_cast<int>(X(max_error_m_ * (i + 1) / kBars)) - 1;
      const cv::Point corner(left, Y(shares[static_cast<std::size_t>(i)]));
      cv::rectangle(picture_, corner, {std::max(left, right), area_.br().y},
                    ScalarOf(i == kBars ? kBeyond : kBar), cv::FILLED);
    }
  }

  void DrawCumulative(const std::vector<double>& shares) {
    std::vector<cv::Point> line = {{area_.x, area_.br().y}};
    double sum = 0;
    for (int i = 0; i < kBars; ++i) {
      sum += shares[static_cast<std::size_t>(i)];
      line.emplace_back(static_cast<int>(X(max_error_m_ * (i + 1) / kBars)), Y(max_share_ * sum));
    }
    cv::polylines(picture_, line, false, ScalarOf(kInk), 2, cv::LINE_AA);
  }

  void DrawThreshold(double threshold_m, double share_below) {
    if (threshold_m > max_error_m_) return;
    const auto x = static_cast<int>(X(threshold_m));
    cv::line(picture_, {x, area_.y}, {x, area_.br().y}, ScalarOf(kInk), 1, cv::LINE_AA);
    Text(FormatNumber("%.1f mm: ", 1000 * threshold_m) + FormatNumber("%.1f %%", 100 * share_below),
         {1.0 * x, area_.y - 12.0}, TextAnchor::kCenter);
  }

  cv::Mat picture() const { return picture_; }

 private:
  double X(double error_m) const {
    return area_.x + area_.width * error_m / max_error_m_ * kBars / (kBars + 1);
  }
  int Y(double share) const {
    return area_.br().y - static_cast<int>(std::lround(area_.height * share / max_share_));
  }
  void Text(const std::string& text, const Eigen::Vector2d& position, TextAnchor anchor) {
    DrawText(text, position, 9, kInk, anchor, 2, &picture_);
  }

  cv::Mat picture_;
  cv::Rect area_;
  double max_error_m_;
  double max_share_;
};

}  // namespace

cv::Mat DrawErrorHistogram(const std::vector<double>& errors_m, double max_error_m,
                           const std::vector<double>& thresholds_m, const cv::Size& size) {
  if (errors_m.empty()) throw Error("error histogram: there are no errors to draw");
  if (size.width < 320 || size.height < 200)
    throw Error("error histogram: the picture is too small");
  const std::vector<double> shares = BarShares(errors_m, max_error_m);
  const double highest = *std::max_element(shares.begin(), shares.end());
  Plot plot(size, max_error_m, std::min(1.0, 0.05 * std::ceil(highest / 0.05)));
  plot.DrawGrid();
  plot.DrawBars(shares);
  plot.DrawCumulative(shares);
  for (const double threshold_m : thresholds_m) {
    const auto below = std::count_if(errors_m.begin(), errors_m.end(),
                                     [&](double error) { return error < threshold_m; });
    plot.DrawThreshold(threshold_m,
                       static_cast<double>(below) / static_cast<double>(errors_m.size()));
  }
  return plot.picture();
}

}  // namespace colmap_ext
