#include "colmap_ext/scene/coverage_map.h"

#include <algorithm>

namespace colmap_ext {

std::size_t CoverageMap::Count(CoverageClass coverage) const {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(),
                    [coverage](const IsoPoint& point) { return point.coverage == coverage; }));
}

double CoverageMap::CoveredRatio() const {
  const auto covered = static_cast<double>(Count(CoverageClass::kCovered));
  const auto uncovered = static_cast<double>(Count(CoverageClass::kUncovered));
  return covered + uncovered > 0 ? covered / (covered + uncovered) : 1.0;
}

}  // namespace colmap_ext
