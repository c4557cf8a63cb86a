// The file of what superpixel stereo keeps of photos, read by this program only
// (docs/file_formats.md). What was written is read again bit by bit.
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "colmap_ext/mvs/stereo_memory.h"

namespace colmap_ext {

// Those photos of `memory` that are in `names`; atomically.
void WriteStereoMemory(const StereoMemory& memory, const std::set<std::string>& names,
                       const std::filesystem::path& path);

// Adds the photos of the file that `memory` does not have yet. Throws Error naming the file when it
// is missing, truncated, of another version, or its indices do not fit together; then it may be
// removed, and its photos are solved again.
void ReadStereoMemory(const std::filesystem::path& path, StereoMemory* memory);

}  // namespace colmap_ext
