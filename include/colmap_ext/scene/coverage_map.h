// The coverage map (paper, Sec. "Coverage Evaluation"): iso-points with their class.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace colmap_ext {

enum class CoverageClass : std::uint8_t { kUncovered = 0, kCovered = 1, kIgnored = 2 };

struct IsoPoint {
  Eigen::Vector3d position;  // world
  Eigen::Vector3d normal;    // unit, outwards
  CoverageClass coverage = CoverageClass::kUncovered;
  double sample_spacing_m = 0;       // Poisson signal, see Surface
  double scatter_m = 0;              // of the points around, see Surface; 0: not known
  int num_good_views = 0;            // projection ratio > γ_min and visible
  double best_projection_ratio = 0;  // px² / m², over the views that see it
  double predicted_error_mm = -1;    // median, of the final model there; -1: no photo sees it
  double score = 0;  // 0 … 1: how sure it is that the final model will be good here
};

struct CoverageMap {
  std::vector<IsoPoint> points;
  double disk_area_m2 = 0;          // surface area that one iso-point stands for
  double min_projection_ratio = 0;  // γ_min used, px² / m²
  double target_error_mm = 0;       // predicted errors above it are uncovered; 0: no such rule

  std::size_t Count(CoverageClass coverage) const;
  // covered / (covered + uncovered); 1 when there are neither.
  double CoveredRatio() const;
};

}  // namespace colmap_ext
