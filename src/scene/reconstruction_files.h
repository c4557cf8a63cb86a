// The two file formats of a sparse model; reconstruction_io.cc chooses between them.
#pragma once

#include <filesystem>
#include <ostream>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Neither checks what the records say about each other (CheckConsistency does).
Reconstruction ReadBinaryModel(const std::filesystem::path& folder);
Reconstruction ReadTextModel(const std::filesystem::path& folder);

// Rigs and frames beside the model, when the folder has them. Throw Error when the table is not
// sound, does not fit the model, or gives its photos other poses.
void ReadBinaryFrameTable(const std::filesystem::path& folder, Reconstruction* model);
void ReadTextFrameTable(const std::filesystem::path& folder, Reconstruction* model);
void WriteBinaryFrameTable(const Reconstruction& model, const std::filesystem::path& folder);
void WriteTextFrameTable(const Reconstruction& model, const std::filesystem::path& folder);

// COLMAP takes poses from its files of frames where there are any: those of an older model would
// override a model that has none.
void RequireNoForeignFrames(const Reconstruction& model, const std::filesystem::path& folder);

// Largest image side that is believed; more means a corrupt file.
inline constexpr std::uint64_t kMaxImageSide = 1'000'000;

// Writes the shortest digits that read back as the same double.
struct Digits {
  double value;
};
std::ostream& operator<<(std::ostream& out, const Digits& digits);

// Unit quaternion from a file's w, x, y, z, as COLMAP does; identical bits when it is unit already.
// A zero or non-finite one becomes a non-finite quaternion, which CheckConsistency reports.
Eigen::Quaterniond RotationFromFile(double w, double x, double y, double z);

}  // namespace colmap_ext
