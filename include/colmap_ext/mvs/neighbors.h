#pragma once

#include <vector>

#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

// For each photo the photos that see most of its points under a useful angle, best first, at most
// options.num_neighbors (paper, Sec. "Linear Dense MVS": 6). A shared point counts by its
// triangulation angle: fully from good_angle_deg on, less below, not above max_angle_deg. Photos
// without a shared point are no neighbours. Ties go to the lower index.
std::vector<std::vector<int>> FindNeighbors(const PhotoSet& photos,
                                            const SuperpixelStereoOptions& options);

}  // namespace colmap_ext
