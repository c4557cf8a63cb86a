#include "colmap_ext/util/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Whether `path` still names the open file: its last holder may have removed it meanwhile.
bool IsSameFile(int descriptor, const std::filesystem::path& path) {
  struct stat opened = {}, named = {};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path, const std::string& busy_message)
    : path_(path) {
  while (true) {
    descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) {
      throw Error(path_.string() + ": cannot be opened: " + std::strerror(errno));
    }
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      close(descriptor_);
      throw Error(busy_message);
    }
    if (IsSameFile(descriptor_, path_)) return;
    close(descriptor_);
  }
}

FileLock::~FileLock() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  close(descriptor_);
}

bool FileLock::IsHeld(const std::filesystem::path& path) {
  const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_held = flock(descriptor, LOCK_EX | LOCK_NB) != 0;
  close(descriptor);
  return is_held;
}

}  // namespace colmap_ext
