// Keeps two programs from working on one thing at once.
#pragma once

#include <filesystem>
#include <string>

namespace colmap_ext {

// Holds an exclusive lock (flock) on a file of its own from construction to destruction; the file
// goes away with the lock. The system releases the lock of a killed program.
class FileLock {
 public:
  // Throws Error(`busy_message`) at once when another program holds the lock, and Error naming the
  // file when it cannot be made.
  FileLock(const std::filesystem::path& path, const std::string& busy_message);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  // Whether a program holds the lock of this file now.
  static bool IsHeld(const std::filesystem::path& path);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace colmap_ext
