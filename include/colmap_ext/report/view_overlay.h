// What the fast stereo made of every photo, small: for the page, which draws it over the photo.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// {"<photo>": {"width", "height", "vertices" (pixels, steps of 1/16), "triangles", "superpixel",
// "confidence" (0 … 100; -1: no SfM point supports the triangle)}}, the arrays packed as
// docs/file_formats.md says. Written atomically. `views`: one a photo of the set, each with
// confidences. Throws Error when the sizes disagree.
void WriteViewOverlays(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                       const std::filesystem::path& path);

}  // namespace colmap_ext
