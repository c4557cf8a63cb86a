// Room on a disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace colmap_ext {

// Bytes that this user may still write where `path` is, or will be: of its nearest folder that is
// there. Throws Error naming the folder when the system does not say.
std::uint64_t FreeDiskBytes(const std::filesystem::path& path);

// One line when `free_bytes` are less than `what` ("the next iteration") needs below `folder`;
// empty when they do.
std::string DiskSpaceComplaint(const std::filesystem::path& folder, const std::string& what,
                               std::uint64_t need_bytes, std::uint64_t free_bytes);

// Of all files below `folder`; 0 when there is no such folder.
std::uint64_t FolderBytes(const std::filesystem::path& folder);

// "812 MB", "1.4 GB": decimal, for people.
std::string BytesText(std::uint64_t bytes);

}  // namespace colmap_ext
