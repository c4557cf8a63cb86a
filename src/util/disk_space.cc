#include "colmap_ext/util/disk_space.h"

#include <sys/statvfs.h>

#include <cerrno>
#include <cstring>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {

std::uint64_t FreeDiskBytes(const std::filesystem::path& path) {
  std::error_code ignored;
  std::filesystem::path folder = std::filesystem::absolute(path).lexically_normal();
  while (!std::filesystem::exists(folder, ignored) && folder.has_relative_path()) {
    folder = folder.parent_path();
  }
  struct statvfs info = {};
  if (statvfs(folder.c_str(), &info) != 0) {
    throw Error(folder.string() + ": the room on its disk is not known: " + std::strerror(errno));
  }
  return std::uint64_t{info.f_bavail} * info.f_frsize;
}

std::string DiskSpaceComplaint(const std::filesystem::path& folder, const std::string& what,
                               std::uint64_t need_bytes, std::uint64_t free_bytes) {
  if (free_bytes >= need_bytes) return "";
  return folder.string() + ": not enough room on this disk: " + what + " needs about " +
         BytesText(need_bytes) + ", " + BytesText(free_bytes) +
         " are free; make room, or choose a folder on another disk";
}

std::uint64_t FolderBytes(const std::filesystem::path& folder) {
  std::error_code error;
  std::uint64_t bytes = 0;
  for (std::filesystem::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (it->is_regular_file(error)) bytes += it->file_size(error);
  }
  return bytes;
}

std::string BytesText(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (value < 999.5e3) return FormatNumber("%.0f kB", value / 1e3);
  if (value < 999.5e6) return FormatNumber("%.0f MB", value / 1e6);
  return FormatNumber("%.1f GB", value / 1e9);
}

}  // namespace colmap_ext
