// Ground-truth camera poses as text.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// The poses of scene/true_poses.h by name, with its errors.
std::map<std::string, Rigid3d> ReadCameraPoses(const std::filesystem::path& path);

}  // namespace colmap_ext
