#include "colmap_ext/scene/workspace.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// The number that a folder name such as "007" stands for.
std::optional<int> IterationFromName(const std::string& name) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (name.size() < 3 || !std::all_of(name.begin(), name.end(), is_digit)) return std::nullopt;
  int index = 0;
  const auto status = std::from_chars(name.data(), name.data() + name.size(), index).ec;
  if (status != std::errc()) return std::nullopt;
  return index;
}

bool HasSparseModel(const std::filesystem::path& folder) {
  for (const char* extension : {".bin", ".txt"}) {
    bool complete = true;
    for (const char* file : {"cameras", "images", "points3D"}) {
      std::error_code ignored;  // an unreadable folder holds no model for us
      complete = complete && std::filesystem::is_regular_file(
                                 folder / (std::string(file) + extension), ignored);
    }
    if (complete) return true;
  }
  return false;
}

}  // namespace

std::filesystem::path Workspace::iteration(int index) const {
  if (index < 0) throw Error("iteration " + std::to_string(index) + " does not exist");
  std::string name = std::to_string(index);
  if (name.size() < 3) name.insert(0, 3 - name.size(), '0');
  return root_ / "iterations" / name;
}

std::optional<int> Workspace::LatestIteration() const {
  const std::filesystem::path folder = root_ / "iterations";
  std::error_code error;
  std::filesystem::directory_iterator it(folder, error);
  if (error == std::errc::no_such_file_or_directory) return std::nullopt;
  if (error) throw Error(folder.string() + ": cannot be read: " + error.message());
  std::optional<int> latest;
  for (const auto& entry : it) {
    const auto index = IterationFromName(entry.path().filename().string());
    // A name with superfluous zeros is not the folder of that iteration.
    if (!index || entry.path().filename() != iteration(*index).filename()) continue;
    if (latest && *index <= *latest) continue;
    if (HasSparseModel(IterationFiles{iteration(*index)}.sparse())) latest = index;
  }
  return latest;
}

}  // namespace colmap_ext
