// Keeps two updates from working on one database at once.
#pragma once

#include <filesystem>

namespace colmap_ext {

// Holds an exclusive lock (flock) for a database from construction to destruction, by a file beside
// it that goes away with the lock. The system releases the lock of a killed program.
class UpdateLock {
 public:
  // Throws Error when another program holds the lock, at once.
  explicit UpdateLock(const std::filesystem::path& database_path);
  ~UpdateLock();
  UpdateLock(const UpdateLock&) = delete;
  UpdateLock& operator=(const UpdateLock&) = delete;

  // The file of the lock for this database.
  static std::filesystem::path PathFor(const std::filesystem::path& database_path);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace colmap_ext
