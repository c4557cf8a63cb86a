// All models side by side, under one light and from one place.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct ModelToPaint {
  std::string caption;
  TriangleMesh mesh;  // in the truth's frame
};

// Two tiles a model: its shape, and the truth coloured by its distance to the model (dark: none,
// yellow: `error_limit_m` and more). Writes one PNG, `columns` models a row.
void PaintSideBySide(const TriangleMesh& truth, const std::vector<ModelToPaint>& models,
                     double error_limit_m, int columns, const std::filesystem::path& png);

}  // namespace colmap_ext
