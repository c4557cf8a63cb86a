#include "mvs/polygon_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mvs/raster.h"

namespace colmap_ext {
namespace {

constexpr double kImpossible = -1.0;

// Smallest height of the triangle, or kImpossible when it is too small.
double Quality(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
               double min_area) {
  const double twice_area = Cross(a, b, c);
  if (!(0.5 * twice_area >= min_area)) return kImpossible;
  const double longest_sq =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return twice_area / std::sqrt(longest_sq);
}

// Dynamic programming over the chords: best[i][j] is the quality of the part between corners i and
// j, apex[i][j] the third corner of the triangle on the chord.
struct ChordTable {
  explicit ChordTable(std::size_t n)
      : size(n), best(n * n, std::numeric_limits<double>::infinity()), apex(n * n, 0) {}
  std::size_t At(std::size_t i, std::size_t j) const { return i * size + j; }
  std::size_t size;
  std::vector<double> best;
  std::vector<std::size_t> apex;
};

void Collect(const ChordTable& table, std::size_t i, std::size_t j, PolygonTriangles* triangles) {
  if (j - i < 2) return;
  const std::size_t k = table.apex[table.At(i, j)];
  triangles->emplace_back(static_cast<int>(i), static_cast<int>(k), static_cast<int>(j));
  Collect(table, i, k, triangles);
  Collect(table, k, j, triangles);
}

}  // namespace

PolygonTriangles TriangulatePolygon(const std::vector<Eigen::Vector2d>& polygon, double min_area) {
  const std::size_t n = polygon.size();
  if (n < 3) return {};
  ChordTable table(n);
  for (std::size_t gap = 2; gap < n; ++gap) {
    for (std::size_t i = 0; i + gap < n; ++i) {
      const std::size_t j = i + gap;
      double best = kImpossible;
      for (std::size_t k = i + 1; k < j; ++k) {
        const double quality = std::min({Quality(polygon[i], polygon[k], polygon[j], min_area),
                                         table.best[table.At(i, k)], table.best[table.At(k, j)]});
        if (quality > best) {
          best = quality;
          table.apex[table.At(i, j)] = k;
        }
      }
      table.best[table.At(i, j)] = best;
    }
  }
  if (table.best[table.At(0, n - 1)] < 0) return {};
  PolygonTriangles triangles;
  Collect(table, 0, n - 1, &triangles);
  return triangles;
}

}  // namespace colmap_ext
