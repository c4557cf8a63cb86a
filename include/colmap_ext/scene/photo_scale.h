#pragma once

#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

// Scales photos wider than `max_width_px` down to that width (area averaging), with their cameras;
// others stay as they are. Photos without pixels get their cameras scaled alike. Poses and points
// stay.
void DownscalePhotos(int max_width_px, PhotoSet* photo_set);

}  // namespace colmap_ext
