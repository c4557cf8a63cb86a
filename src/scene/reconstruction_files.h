// The two file formats of a sparse model; reconstruction_io.cc chooses between them.
#pragma once

#include <filesystem>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Neither checks what the records say about each other (CheckConsistency does).
Reconstruction ReadBinaryModel(const std::filesystem::path& folder);
Reconstruction ReadTextModel(const std::filesystem::path& folder);

// Largest image side that is believed; more means a corrupt file.
inline constexpr std::uint64_t kMaxImageSide = 1'000'000;

// Unit quaternion from a file's w, x, y, z, as COLMAP does; identical bits when it is unit already.
// A zero or non-finite one becomes a non-finite quaternion, which CheckConsistency reports.
Eigen::Quaterniond RotationFromFile(double w, double x, double y, double z);

}  // namespace colmap_ext
