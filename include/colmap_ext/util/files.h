// Files that are replaced atomically: a reader sees the old content or the new, never half of it.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace colmap_ext {

// Calls `write` with a binary stream to a temporary file beside `path`, syncs it, then renames it
// over `path`. Parent folders are created. Throws Error (naming `path`) and leaves the old file
// when anything fails, a full disk included.
void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write);

// The same for text or bytes in memory.
void WriteFileAtomically(const std::filesystem::path& path, const std::string& content);

// A name beside `path` for a temporary file that keeps its extension (writers that choose the
// format by extension need it); pair with CommitTemporaryFile.
std::filesystem::path TemporaryPathFor(const std::filesystem::path& path);
// fsyncs `temporary` and renames it over `path`.
void CommitTemporaryFile(const std::filesystem::path& temporary, const std::filesystem::path& path);

// Whole content. Throws Error naming the file when it cannot be read.
std::string ReadFile(const std::filesystem::path& path);

// Throws Error naming `path` and `what` ("image folder") when it is not there.
void RequireFile(const std::filesystem::path& path, const std::string& what);
void RequireFolder(const std::filesystem::path& path, const std::string& what);
// Creates the folder if needed and proves by a probe file that it can be written to.
void RequireWritableFolder(const std::filesystem::path& path, const std::string& what);

// Names of the photos (.jpg .jpeg .png .tif .tiff, any case) below `folder`, relative to it, with
// '/' between folders, sorted.
std::vector<std::string> ListPhotos(const std::filesystem::path& folder);

}  // namespace colmap_ext
