#include "update_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

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

std::filesystem::path UpdateLock::PathFor(const std::filesystem::path& database_path) {
  return database_path.parent_path() / ("." + database_path.filename().string() + ".lock");
}

UpdateLock::UpdateLock(const std::filesystem::path& database_path) : path_(PathFor(database_path)) {
  while (true) {
    descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) {
      throw Error(path_.string() + ": cannot be opened: " + std::strerror(errno));
    }
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      close(descriptor_);
      throw Error(database_path.string() +
                  ": another update of this database is running; wait until it has ended");
    }
    if (IsSameFile(descriptor_, path_)) return;
    close(descriptor_);
  }
}

UpdateLock::~UpdateLock() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  close(descriptor_);
}

}  // namespace colmap_ext
