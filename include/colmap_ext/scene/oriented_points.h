#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace colmap_ext {

// One point of the fused cloud.
struct OrientedPoint {
  Eigen::Vector3d position;  // world
  Eigen::Vector3d normal;    // unit, towards the camera that saw it
  Eigen::Matrix<std::uint8_t, 3, 1> color = Eigen::Matrix<std::uint8_t, 3, 1>::Zero();  // RGB
  float confidence = 1;  // Γ, 0 … 1
  int photo_index = -1;  // the photo whose mesh it came from; -1 unknown
};

using OrientedPoints = std::vector<OrientedPoint>;

}  // namespace colmap_ext
