// Text and panels of pictures. OpenCV's only built-in fonts are strokes without antialiased curves:
// they are drawn four times as large and scaled down.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/report/picture_overlay.h"
#include "report/blend.h"

namespace colmap_ext {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;
constexpr double kCapitalPx = 21.0;  // height of the font's capitals at scale 1
constexpr int kOversampling = 4;

std::string Printable(std::string text) {
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

double FontScale(double height_px) { return height_px / kCapitalPx; }

// Coverage of the text, `stroke_px` wide, the anchor's left end at (margin, middle row).
cv::Mat TextMask(const std::string& text, double height_px, double stroke_px, int width, int height,
                 double left_px) {
  cv::Mat large(height * kOversampling, width * kOversampling, CV_8U, cv::Scalar(0));
  const int baseline =
      static_cast<int>(std::lround((0.5 * height + 0.5 * height_px) * kOversampling));
  cv::putText(large, text, {static_cast<int>(std::lround(left_px * kOversampling)), baseline},
              kFont, FontScale(height_px) * kOversampling, cv::Scalar(255),
              std::max(1, static_cast<int>(std::lround(stroke_px * kOversampling))), cv::LINE_AA);
  cv::Mat small, mask;
  cv::resize(large, small, {width, height}, 0, 0, cv::INTER_AREA);
  small.convertTo(mask, CV_32F, 1.0 / 255);
  return mask;
}

// Blends a small mask whose upper left pixel is (left, top), cut at the borders.
void BlendPatch(const cv::Mat& mask, int left, int top, const Rgb& color, cv::Mat* bgr) {
  const cv::Rect wanted(left, top, mask.cols, mask.rows);
  const cv::Rect inside = wanted & cv::Rect(0, 0, bgr->cols, bgr->rows);
  if (inside.empty()) return;
  cv::Mat part = (*bgr)(inside);
  BlendColor(mask(inside - wanted.tl()), color, 1.0, &part);
}

}  // namespace

double TextWidth(const std::string& text, double height_px) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(Printable(text), kFont, 8.0, 1, &baseline);
  return size.width / 8.0 * FontScale(height_px);
}

void DrawText(const std::string& text, const Eigen::Vector2d& position, double height_px,
              const Rgb& color, TextAnchor anchor, double halo_px, cv::Mat* bgr) {
  const std::string printable = Printable(text);
  const double width = TextWidth(text, height_px);
  double left = position.x();
  if (anchor == TextAnchor::kCenter) left -= 0.5 * width;
  if (anchor == TextAnchor::kRight) left -= width;
  const int margin = static_cast<int>(std::ceil(halo_px)) + 4;
  const int patch_width = static_cast<int>(std::ceil(width)) + 2 * margin + 1;
  const int patch_height = 2 * (static_cast<int>(std::ceil(height_px)) + margin);
  const int patch_left = static_cast<int>(std::floor(left)) - margin;
  const int patch_top = static_cast<int>(std::lround(position.y() - 0.5 * patch_height));
  const double stroke = std::max(1.0, 0.115 * height_px);
  const auto mask = [&](double stroke_px) {
    return TextMask(printable, height_px, stroke_px, patch_width, patch_height, left - patch_left);
  };
  if (halo_px > 0) {
    BlendPatch(mask(stroke + 2 * halo_px), patch_left, patch_top, {1, 1, 1}, bgr);
  }
  BlendPatch(mask(stroke), patch_left, patch_top, color, bgr);
}

void DrawBadge(const std::string& text, const Eigen::Vector2d& center, double height_px,
               const Rgb& color, cv::Mat* bgr) {
  const double inner = std::max(TextWidth(text, height_px) + 0.9 * height_px, 2.1 * height_px);
  const auto rectangle = [&](double border) {
    const double width = inner + 2 * border, height = 2.1 * height_px + 2 * border;
    return cv::Rect2d(center.x() - 0.5 * width, center.y() - 0.5 * height, width, height);
  };
  const cv::Size size = bgr->size();
  BlendColor(RoundedRectangle(size, rectangle(1.5), 1.05 * height_px + 1.5), {1, 1, 1}, 1, bgr);
  BlendColor(RoundedRectangle(size, rectangle(0), 1.05 * height_px), color, 1, bgr);
  DrawText(text, center, height_px, {1, 1, 1}, TextAnchor::kCenter, 0, bgr);
}

void DrawLegend(const std::string& title, const std::vector<LegendRow>& rows, cv::Mat* bgr) {
  const double text_px = std::max(9.0, bgr->rows / 72.0);
  const double row_px = 2.1 * text_px, pad_px = 1.5 * text_px, swatch_px = 1.5 * text_px;
  double label_width = TextWidth(title, 1.15 * text_px), value_width = 0;
  for (const LegendRow& row : rows) {
    const double gap = row.value.empty() ? 0 : 1.6 * text_px;
    label_width = std::max(label_width, 1.7 * swatch_px + TextWidth(row.label, text_px) + gap);
    value_width = std::max(value_width, TextWidth(row.value, text_px));
  }
  const double width = label_width + value_width + 2 * pad_px;
  const double height = row_px * static_cast<double>(rows.size() + 1) + 1.5 * pad_px;
  const cv::Rect2d panel(pad_px, bgr->rows - pad_px - height, width, height);
  BlendColor(RoundedRectangle(bgr->size(), panel, 0.7 * text_px), {1, 1, 1}, 0.86, bgr);

  const Rgb ink(0.13f, 0.16f, 0.20f);
  const double left = panel.x + pad_px;
  double y = panel.y + 0.75 * pad_px + 0.5 * row_px;
  DrawText(title, {left, y}, 1.15 * text_px, ink, TextAnchor::kLeft, 0, bgr);
  for (const LegendRow& row : rows) {
    y += row_px;
    const double swatch_height = row.is_line ? 0.28 * swatch_px : 0.8 * swatch_px;
    const cv::Rect2d swatch(left, y - 0.5 * swatch_height, swatch_px, swatch_height);
    BlendColor(RoundedRectangle(bgr->size(), swatch, 0.14 * swatch_height + 1), row.color, 1, bgr);
    DrawText(row.label, {left + 1.7 * swatch_px, y}, text_px, ink, TextAnchor::kLeft, 0, bgr);
    DrawText(row.value, {panel.x + width - pad_px, y}, text_px, ink, TextAnchor::kRight, 0, bgr);
  }
}

}  // namespace colmap_ext
