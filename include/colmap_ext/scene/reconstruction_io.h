// Reads and writes COLMAP's sparse models, binary and text, as documented at
// https://colmap.github.io/format.html. Readers accept models of 3.8 to 4.x; where there are files
// of rigs and frames (3.12 and later), they are read too, and must agree with the photos' poses.
#pragma once

#include <filesystem>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Binary when cameras.bin is there, else text. The result passes CheckConsistency. Throws Error
// naming the file and byte offset (binary) or line (text) of what is missing, truncated or corrupt.
Reconstruction ReadReconstruction(const std::filesystem::path& folder);

// Each file is replaced atomically; the folder is created. A model with a frame table is written
// with rigs and frames, completed by FrameTableOf; one without is written as 3.8 does, which every
// later version reads as one frame a photo. Throw Error when the model does not pass
// CheckConsistency, and when the folder holds files that a reader would prefer: rigs and frames of
// another model, cameras.bin (text). COLMAP reads a name in text only up to its first blank.
void WriteReconstructionBinary(const Reconstruction& reconstruction,
                               const std::filesystem::path& folder);
void WriteReconstructionText(const Reconstruction& reconstruction,
                             const std::filesystem::path& folder);

}  // namespace colmap_ext
