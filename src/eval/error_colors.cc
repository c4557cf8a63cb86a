#include "colmap_ext/eval/error_colors.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace colmap_ext {

std::vector<Eigen::Vector3d> ErrorColors(const std::vector<double>& errors_m, double max_error_m) {
  const std::array<Eigen::Vector3d, 5> stops = {
      Eigen::Vector3d(0.10, 0.15, 0.45), Eigen::Vector3d(0.15, 0.40, 0.60),
      Eigen::Vector3d(0.20, 0.62, 0.58), Eigen::Vector3d(0.65, 0.80, 0.38),
      Eigen::Vector3d(0.99, 0.91, 0.20)};
  std::vector<Eigen::Vector3d> colors;
  colors.reserve(errors_m.size());
  for (const double error : errors_m) {
    const double position =
        std::clamp(error / max_error_m, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(position), stops.size() - 2);
    const double share = position - static_cast<double>(below);
    colors.emplace_back((1 - share) * stops[below] + share * stops[below + 1]);
  }
  return colors;
}

}  // namespace colmap_ext
