// Arrays of numbers inside the page's JSON, small enough for millions of points.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

// {"components": k, "count": values.size() / k, "data": base64}. The data are zlib's deflate of one
// variable-length number (LEB128, low bits first) a value: the zigzag code of its difference to the
// value `components` places before (0 before the first ones). What web/src/packed.js reads.
Json PackIntegers(std::span<const std::int32_t> values, int components);

// The same for points, three components: rounded((p - origin) / step_m), and "step": step_m.
// Coordinates beyond ±2³⁰ steps are clamped there. `step_m` > 0.
Json PackPositions(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin,
                   double step_m);

// Order of `points` along a Z-shaped curve: neighbours in it are neighbours in space, so that
// differences are small.
std::vector<std::size_t> SpatialOrder(const std::vector<Eigen::Vector3d>& points);

}  // namespace colmap_ext
