#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"
#include "survey.h"

namespace colmap_ext {

// <folder>/<scene photo>.png: the photo with its triangles, true inverse depth, Γ (green: over 0.5
// and within 2 %; red: over 0.5 and more wrong; blue: below, brighter with Γ), the mesh's inverse
// depth.
void WriteErrorPictures(const Survey& survey, const std::vector<ViewMesh>& views, int every,
                        const std::filesystem::path& folder);

}  // namespace colmap_ext
