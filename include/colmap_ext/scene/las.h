// Laser scans as LAS files (ASPRS LAS 1.0 to 1.4, uncompressed).
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace colmap_ext {

// The points' coordinates, in the units and the frame of the file (scale and offset of its header
// applied). Throws Error naming the file: not LAS, compressed (LAZ), or shorter than its header
// says.
std::vector<Eigen::Vector3d> ReadLasPoints(const std::filesystem::path& path);

}  // namespace colmap_ext
