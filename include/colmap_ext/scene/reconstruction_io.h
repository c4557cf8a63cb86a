// Reads and writes COLMAP's sparse models, binary and text, as documented at
// https://colmap.github.io/format.html. Readers accept models of 3.8 to 4.x (rigs.bin and
// frames.bin of 4.x are not needed: images.bin carries the poses).
#pragma once

#include <filesystem>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Binary when cameras.bin is there, else text. The result passes CheckConsistency. Throws Error
// naming the file and byte offset (binary) or line (text) of what is missing, truncated or corrupt.
Reconstruction ReadReconstruction(const std::filesystem::path& folder);

// Each file is replaced atomically; the folder is created. Throw Error when the model does not pass
// CheckConsistency, and when the folder holds files that a reader would prefer: rigs.bin or
// frames.bin of 4.x (binary), cameras.bin (text). COLMAP 3.8 reads a name in text only up to its
// first blank.
void WriteReconstructionBinary(const Reconstruction& reconstruction,
                               const std::filesystem::path& folder);
void WriteReconstructionText(const Reconstruction& reconstruction,
                             const std::filesystem::path& folder);

}  // namespace colmap_ext
