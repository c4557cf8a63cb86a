// Colours of sparse points, as COLMAP's viewer shows them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Gives the points that have no colour yet (black) the mean colour of their keypoints in these
// photos, files below `image_path` as COLMAP reads them (not turned by EXIF). A photo that cannot
// be read colours nothing. Same result for any number of threads.
void ColorPoints(const std::filesystem::path& image_path, const std::vector<std::string>& photos,
                 Reconstruction* model);

}  // namespace colmap_ext
