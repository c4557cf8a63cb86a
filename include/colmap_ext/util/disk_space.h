// Room on a disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace colmap_ext {

// Bytes that this user may still write where `path` is, or will be: of its nearest folder that is
// there. Throws Error naming the folder when the system does not say.
std::uint64_t FreeDiskBytes(const std::filesystem::path& path);

// "812 MB", "1.4 GB": decimal, for people.
std::string BytesText(std::uint64_t bytes);

}  // namespace colmap_ext
