#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// RGB 0 … 1 of each error: dark blue (0) over teal to yellow (max_error_m and more); rising in
// lightness, so that it reads without red and green. `max_error_m` > 0.
std::vector<Eigen::Vector3d> ErrorColors(const std::vector<double>& errors_m, double max_error_m);

}  // namespace colmap_ext
