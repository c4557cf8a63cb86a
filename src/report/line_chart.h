#pragma once

#include <optional>
#include <string>
#include <vector>

namespace colmap_ext {

struct ChartSeries {
  std::string label;                          // drawn at the end of its line
  std::string css_class;                      // "series-1" …: the page gives the colour
  std::vector<std::optional<double>> values;  // one an iteration; gaps are left open
};

struct LineChart {
  std::string title;
  std::string unit;  // after each value: " %"
  std::vector<ChartSeries> series;
  double min_value = 0;
  std::optional<double> max_value;  // absent: chosen from the values
};

// Inline SVG (no scripts, texts escaped). Every point carries its value as a tooltip. Empty when no
// series has a value.
std::string LineChartSvg(const LineChart& chart);

}  // namespace colmap_ext
