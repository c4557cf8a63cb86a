// Keeps two updates from working on one database at once.
#pragma once

#include <filesystem>

#include "colmap_ext/util/file_lock.h"

namespace colmap_ext {

// Holds the lock of a database from construction to destruction, by a file beside it.
class UpdateLock {
 public:
  // Throws Error when another program holds the lock, at once.
  explicit UpdateLock(const std::filesystem::path& database_path);

  // The file of the lock for this database.
  static std::filesystem::path PathFor(const std::filesystem::path& database_path);

 private:
  FileLock lock_;
};

}  // namespace colmap_ext
