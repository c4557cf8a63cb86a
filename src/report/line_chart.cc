#include "report/line_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "report/html_text.h"

namespace colmap_ext {
namespace {

constexpr double kWidth = 460, kHeight = 220;
constexpr double kLeft = 46, kRight = 78, kTop = 14, kBottom = 30;
constexpr double kLabelGap = 15;  // between labels at line ends

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::round(value * 100) / 100);
  return text;
}

// A round number of at least `value`: 1, 2, 2.5 or 5 times a power of ten.
double RoundUp(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

class Chart {
 public:
  explicit Chart(const LineChart& chart) : chart_(chart) {
    double largest = 0;
    for (const ChartSeries& series : chart.series) {
      count_ = std::max(count_, series.values.size());
      for (const auto& value : series.values) {
        if (!value) continue;
        has_values_ = true;
        largest = std::max(largest, *value);
      }
    }
    top_ = chart.max_value.value_or(RoundUp(largest));
  }

  bool has_values() const { return has_values_; }

  std::string Svg() const {
    std::string svg = "<svg class=\"chart\" viewBox=\"0 0 " + Number(kWidth) + " " +
                      Number(kHeight) + "\" role=\"img\" aria-label=\"" + EscapeHtml(chart_.title) +
                      "\">\n";
    svg += Axes();
    const std::vector<double> label_y = LabelRows();
    for (std::size_t i = 0; i < chart_.series.size(); ++i) {
      svg += SeriesSvg(chart_.series[i], label_y[i]);
    }
    return svg + "</svg>\n";
  }

 private:
  double X(std::size_t index) const {
    const double share =
        count_ > 1 ? static_cast<double>(index) / static_cast<double>(count_ - 1) : 0.5;
    return kLeft + share * (kWidth - kLeft - kRight);
  }

  double Y(double value) const {
    const double share = (value - chart_.min_value) / (top_ - chart_.min_value);
    return kHeight - kBottom - std::clamp(share, 0.0, 1.0) * (kHeight - kTop - kBottom);
  }

  std::string Axes() const {
    std::string svg;
    constexpr int kSteps = 4;
    for (int i = 0; i <= kSteps; ++i) {
      const double value = chart_.min_value + (top_ - chart_.min_value) * i / kSteps;
      const std::string y = Number(Y(value));
      svg += "<line class=\"grid\" x1=\"" + Number(kLeft) + "\" x2=\"" + Number(kWidth - kRight) +
             "\" y1=\"" + y + "\" y2=\"" + y + "\"/>";
      svg += "<text class=\"tick\" text-anchor=\"end\" x=\"" + Number(kLeft - 8) + "\" y=\"" +
             Number(Y(value) + 4) + "\">" + Number(value) + "</text>\n";
    }
    const std::size_t every = count_ / 10 + 1;  // at most ten numbers below the axis
    for (std::size_t i = 0; i < count_; i += every) {
      svg += "<text class=\"tick\" text-anchor=\"middle\" x=\"" + Number(X(i)) + "\" y=\"" +
             Number(kHeight - 10) + "\">" + std::to_string(i) + "</text>";
    }
    return svg + "\n";
  }

  // Heights of the labels at the line ends, pushed apart where lines end close together.
  std::vector<double> LabelRows() const {
    std::vector<std::pair<double, std::size_t>> ends;
    for (std::size_t i = 0; i < chart_.series.size(); ++i) {
      double y = kHeight;
      for (const auto& value : chart_.series[i].values) {
        if (value) y = Y(*value);
      }
      ends.emplace_back(y, i);
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t i = 1; i < ends.size(); ++i) {
      ends[i].first = std::max(ends[i].first, ends[i - 1].first + kLabelGap);
    }
    std::vector<double> rows(ends.size());
    for (const auto& [y, index] : ends) rows[index] = y;
    return rows;
  }

  std::string SeriesSvg(const ChartSeries& series, double label_y) const {
    std::string path, points;
    bool is_open = false;
    double last_x = 0;
    for (std::size_t i = 0; i < series.values.size(); ++i) {
      if (!series.values[i]) {
        is_open = false;
        continue;
      }
      const std::string x = Number(X(i)), y = Number(Y(*series.values[i]));
      path += (is_open ? "L" : "M") + x + " " + y + " ";
      points += "<circle cx=\"" + x + "\" cy=\"" + y + "\" r=\"4\"><title>Iteration " +
                std::to_string(i) + ": " + EscapeHtml(series.label) + " " +
                Number(*series.values[i]) + EscapeHtml(chart_.unit) + "</title></circle>";
      is_open = true;
      last_x = X(i);
    }
    if (points.empty()) return "";
    return "<g class=\"" + series.css_class + "\"><path d=\"" + path + "\"/>" + points +
           "<text x=\"" + Number(last_x + 10) + "\" y=\"" + Number(label_y + 4) + "\">" +
           EscapeHtml(series.label) + "</text></g>\n";
  }

  const LineChart& chart_;
  std::size_t count_ = 0;
  bool has_values_ = false;
  double top_ = 1;
};

}  // namespace

std::string LineChartSvg(const LineChart& chart) {
  const Chart drawn(chart);
  return drawn.has_values() ? drawn.Svg() : "";
}

}  // namespace colmap_ext
