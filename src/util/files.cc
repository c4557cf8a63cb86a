#include "colmap_ext/util/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

std::string SystemReason() { return errno == 0 ? "unknown reason" : std::strerror(errno); }

void SyncFile(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw Error(path.string() + ": cannot be opened again: " + SystemReason());
  const int result = fsync(descriptor);
  const std::string reason = SystemReason();
  close(descriptor);
  if (result != 0) throw Error(path.string() + ": cannot be written to disk: " + reason);
}

// The new name is on the disk only when its folder is. Some file systems cannot sync a folder; they
// keep the order of renames themselves.
void SyncFolderOf(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

void RemoveQuietly(const fs::path& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

void CreateParentFolder(const fs::path& path) {
  const fs::path folder = path.parent_path();
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(folder.string() + ": cannot create the folder: " + error.message());
}

}  // namespace

fs::path TemporaryPathFor(const fs::path& path) {
  return path.parent_path() / ("." + path.stem().string() + ".tmp" + std::to_string(getpid()) +
                               path.extension().string());
}

void CommitTemporaryFile(const fs::path& temporary, const fs::path& path) {
  try {
    SyncFile(temporary);
    std::error_code error;
    fs::rename(temporary, path, error);
    if (error) throw Error(path.string() + ": cannot be replaced: " + error.message());
    SyncFolderOf(path);
  } catch (const Error&) {
    RemoveQuietly(temporary);
    throw;
  }
}

void WriteFileAtomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  CreateParentFolder(path);
  const fs::path temporary = TemporaryPathFor(path);
  errno = 0;
  try {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    if (!stream) throw Error(path.string() + ": cannot be written: " + SystemReason());
    write(stream);
    stream.close();
    if (!stream) throw Error(path.string() + ": writing failed: " + SystemReason());
  } catch (...) {
    RemoveQuietly(temporary);
    throw;
  }
  CommitTemporaryFile(temporary, path);
}

void WriteFileAtomically(const fs::path& path, const std::string& content) {
  WriteFileAtomically(path, [&content](std::ostream& stream) {
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  });
}

std::string ReadFile(const fs::path& path) {
  RequireFile(path, "file");
  std::ifstream stream(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad()) {
    throw Error(path.string() + ": cannot be read: " + SystemReason());
  }
  return content;
}

void RequireFile(const fs::path& path, const std::string& what) {
  std::error_code error;
  if (!fs::exists(path, error)) throw Error(path.string() + ": no such file (" + what + ")");
  if (fs::is_directory(path, error)) {
    throw Error(path.string() + ": is a folder, but a file is needed (" + what + ")");
  }
}

void RequireFolder(const fs::path& path, const std::string& what) {
  std::error_code error;
  if (!fs::exists(path, error)) throw Error(path.string() + ": no such folder (" + what + ")");
  if (!fs::is_directory(path, error)) {
    throw Error(path.string() + ": is not a folder (" + what + ")");
  }
}

void RequireWritableFolder(const fs::path& path, const std::string& what) {
  CreateParentFolder(path / "probe");
  RequireFolder(path, what);
  const fs::path probe = path / (".write_probe." + std::to_string(getpid()));
  errno = 0;
  std::ofstream stream(probe);
  stream << "probe";
  stream.close();
  const bool is_good = static_cast<bool>(stream);
  const std::string reason = SystemReason();
  RemoveQuietly(probe);
  if (!is_good)
    throw Error(path.string() + ": cannot write to this folder (" + what + "): " + reason);
}

std::vector<std::string> ListPhotos(const fs::path& folder) {
  RequireFolder(folder, "photos");
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool is_photo = extension == ".jpg" || extension == ".jpeg" || extension == ".png" ||
                          extension == ".tif" || extension == ".tiff";
    const bool is_hidden = entry.path().filename().string().starts_with('.');
    if (!is_photo || is_hidden || !entry.is_regular_file()) continue;
    names.push_back(entry.path().lexically_relative(folder).generic_string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace colmap_ext
