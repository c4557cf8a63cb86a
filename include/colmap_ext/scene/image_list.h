// Lists of photos by name, as COLMAP's --image_list_path has them: one name a line.
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "colmap_ext/scene/workspace.h"

namespace colmap_ext {

// Blank lines and blanks around a name are left out, lines that begin with '#' are comments. Throws
// Error naming the file when it cannot be read or names nothing.
std::set<std::string> ReadImageList(const std::filesystem::path& path);
void WriteImageList(const std::set<std::string>& names, const std::filesystem::path& path);

// The photos of the first iteration of a session, which the pilot took or had taken, and vouches
// for: first_flight.txt; of a session without it, the registered photos of its first iteration.
// Throws Error when there is neither.
std::set<std::string> FirstFlightPhotos(const Workspace& workspace);

}  // namespace colmap_ext
