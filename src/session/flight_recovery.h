// A simulated drone ends with its session, and what its camera held ends with it. Before another
// one takes its place, the workspace is brought to what is on disk.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Folder of the simulated drone's pictures and truth, while its session runs.
std::filesystem::path DronePath(const Workspace& workspace);

// Photos that the last drone took and the daemon stored keep their place: their true poses go to
// truth/poses.txt, their full resolution, where `full_resolution`, to images_full/. What was taken
// and not stored is pending again in the flight journal. The drone's folder is then empty. Warns of
// photos whose full resolution is lost. Needs that no daemon runs. Throws Error for files that
// cannot be read or written.
void RecoverFromLastDrone(const Workspace& workspace, bool full_resolution, const JobControl& job);

// Adds the true poses of photos that this drone took to truth/poses.txt; its picture index by name
// of the photo.
void TakeTruePoses(const std::map<std::string, int>& index_of_photo, const Workspace& workspace);

}  // namespace colmap_ext
