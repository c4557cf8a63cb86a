// Views to render: from a text file, or an overview of a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

struct NamedView {
  std::string name;  // of the photo: relative, with extension .jpg
  PlannedView view;  // ids count from 0
};

// A view a line, `name x y z yaw_deg pitch_deg`: metres in the scene's ENU frame, yaw clockwise
// from north, pitch positive up. Empty lines and text after '#' are skipped; `.jpg` is appended to
// names without an extension. Throws Error naming file and line of what is wrong: a missing or
// non-finite number, a pitch outside [-90, 90], a name that is absolute, leaves the folder or comes
// twice; and when there is no view at all.
std::vector<NamedView> ReadPoseList(const std::filesystem::path& path);

// Six views of the model from around and above (north, north east, …), one from near the ground and
// one from close by, inside the scene's ground area.
std::vector<NamedView> OverviewOf(const TexturedScene& scene);

}  // namespace colmap_ext
