// Cuts faces out of a surface.
#pragma once

#include <vector>

#include "colmap_ext/scene/surface.h"

namespace colmap_ext {

// Keeps the faces marked true; vertices of no face go. Order is kept.
Surface KeepFaces(const Surface& surface, const std::vector<bool>& keep);

// One entry a face: true when the piece that it belongs to (connected by shared vertices) has an
// area of at least min_area_m2. The largest piece is always kept.
std::vector<bool> FacesOfLargePieces(const TriangleMesh& mesh, double min_area_m2);

double TotalArea(const TriangleMesh& mesh);  // m²

}  // namespace colmap_ext
