// True camera poses as text, for evaluation: a line a photo, `name qw qx qy qz tx ty tz`
// (cam_from_world, COLMAP's order).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

struct TruePose {
  std::string name;  // may hold single spaces; no '#'
  Rigid3d cam_from_world;
};

// Sorted by name. Empty lines are skipped, and what follows a '#'. Quaternions are normalised.
// Throws Error naming file and line of a wrong number of words, a bad number, a quaternion that is
// not of unit length within 1 %, and a photo named twice.
std::vector<TruePose> ReadTruePoses(const std::filesystem::path& path);

// Sorted by name, replaced atomically; comes back to rounding. Throws Error for a name that would
// not come back.
void WriteTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path);

// Adds to the file, or replaces poses of the same names; the file may not exist yet.
void UpdateTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path);

std::map<std::string, Rigid3d> PoseOfPhoto(const std::vector<TruePose>& poses);

}  // namespace colmap_ext
