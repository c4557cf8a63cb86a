// MAVLink's whole numbers of positions.
#pragma once

#include <cmath>
#include <cstdint>

namespace colmap_ext {

// Degrees as 1e-7 degrees.
inline std::int32_t DegE7(double deg) { return static_cast<std::int32_t>(std::lround(deg * 1e7)); }

// Metres as millimetres.
inline std::int32_t Millimetres(double m) {
  return static_cast<std::int32_t>(std::lround(m * 1e3));
}

}  // namespace colmap_ext
