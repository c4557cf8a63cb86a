#include "colmap_ext/scene/image_list.h"

#include <sstream>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

std::set<std::string> ReadImageList(const std::filesystem::path& path) {
  RequireFile(path, "list of photos");
  std::set<std::string> names;
  std::istringstream lines(ReadFile(path));
  for (std::string line; std::getline(lines, line);) {
    constexpr const char* kBlanks = " \t\r";
    const std::size_t first = line.find_first_not_of(kBlanks);
    if (first == std::string::npos || line[first] == '#') continue;
    names.insert(line.substr(first, line.find_last_not_of(kBlanks) - first + 1));
  }
  if (names.empty()) throw Error(path.string() + ": names no photo; give one name a line");
  return names;
}

void WriteImageList(const std::set<std::string>& names, const std::filesystem::path& path) {
  std::string text;
  for (const std::string& name : names) text += name + '\n';
  WriteFileAtomically(path, text);
}

std::set<std::string> FirstFlightPhotos(const Workspace& workspace) {
  const std::filesystem::path list = workspace.first_flight_txt();
  if (std::filesystem::exists(list)) return ReadImageList(list);
  std::set<std::string> names;
  const IterationFiles first{workspace.iteration(0)};
  for (const auto& [id, image] : ReadReconstruction(first.sparse()).images) {
    names.insert(image.name);
  }
  return names;
}

}  // namespace colmap_ext
