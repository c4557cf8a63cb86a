#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace colmap_ext {
namespace raster_internal {

// An edge as x over y. Computed from its upper end, so that the two triangles of an edge get the
// same numbers and no pixel falls between them.
struct EdgeLine {
  EdgeLine(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    const bool p_first = p.y() < q.y() || (p.y() == q.y() && p.x() < q.x());
    const Eigen::Vector2d& top = p_first ? p : q;
    const Eigen::Vector2d& bottom = p_first ? q : p;
    top_x = top.x();
    top_y = top.y();
    bottom_y = top.y() == bottom.y() ? -std::numeric_limits<double>::infinity() : bottom.y();
    slope = (bottom.x() - top.x()) / (bottom.y() - top.y());
  }
  void ExtendSpan(double y, double* low, double* high) const {
    if (y < top_y || y > bottom_y) return;
    const double x = top_x + (y - top_y) * slope;
    *low = std::min(*low, x);
    *high = std::max(*high, x);
  }
  double top_x, top_y, bottom_y, slope;
};

// Smallest n >= 0 with n * step + step / 2 + 0.5 >= value.
inline int FirstIndex(double value, int step) {
  return std::max(0, static_cast<int>(std::ceil((value - 0.5 - step / 2) / step)));
}

}  // namespace raster_internal

template <typename Visit>
void ForEachPixelInTriangle(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                            const Eigen::Vector2d& c, int width, int height, int step,
                            const Visit& visit) {
  const double min_y = std::min({a.y(), b.y(), c.y()});
  const double max_y = std::min(std::max({a.y(), b.y(), c.y()}), static_cast<double>(height));
  const raster_internal::EdgeLine edges[3] = {{a, b}, {b, c}, {c, a}};
  for (int row = raster_internal::FirstIndex(min_y, step);; ++row) {
    const int y = row * step + step / 2;
    const double center_y = y + 0.5;
    if (center_y > max_y) break;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const raster_internal::EdgeLine& edge : edges) edge.ExtendSpan(center_y, &low, &high);
    high = std::min(high, static_cast<double>(width));
    if (!(low <= high)) continue;
    for (int column = raster_internal::FirstIndex(low, step);; ++column) {
      const int x = column * step + step / 2;
      if (x + 0.5 > high) break;
      visit(x, y);
    }
  }
}

}  // namespace colmap_ext
