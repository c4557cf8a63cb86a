// Runs of our own program, and models brought to the truth of the simulator.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Runs `colmap_ext <arguments>` with its output in `log_path`, whose folder is made. Throws Error
// when it fails.
ChildProcessResult RunColmapExt(std::vector<std::string> arguments,
                                const std::filesystem::path& log_path, const JobControl& job);

// The model moved to the truth by its camera centres (a similarity). With `true_poses` the photos
// then get their true poses, and the points stay. `pose_of`: true cam_from_world by photo name; of
// every photo of the model.
Reconstruction BroughtToTruth(Reconstruction model, const std::map<std::string, Rigid3d>& pose_of,
                              bool true_poses);

}  // namespace colmap_ext
