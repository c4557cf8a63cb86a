// Ground-truth camera poses as text.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// Lines of `name qw qx qy qz tx ty tz` (cam_from_world, COLMAP's order); empty lines and lines that
// start with '#' are skipped; a name may contain spaces. Quaternions are normalised. Throws Error
// naming file and line for anything else, a name given twice included.
std::map<std::string, Rigid3d> ReadCameraPoses(const std::filesystem::path& path);

}  // namespace colmap_ext
