// The photos as the page shows them: small and undistorted.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Folder, relative to the page, of photos at most `width_px` wide: "photos_960".
std::string PagePhotoFolder(int width_px);

// Where the photos of a session are, as its state.json says; images/ of the workspace when they are
// simulated or there is no state.
std::filesystem::path PhotoFolderOfWorkspace(const Workspace& workspace);

// Writes <folder>/<PagePhotoFolder>/<name>.jpg of every registered photo of the newest iteration,
// unless it is there and newer than the photo. Pixels are those of ToPinhole(camera), scaled.
// Photos that cannot be read are left out, and a warning says how many and why the first one.
void WritePagePhotos(const Workspace& workspace, const std::filesystem::path& image_path,
                     int width_px, const std::filesystem::path& folder, const JobControl& job);

}  // namespace colmap_ext
