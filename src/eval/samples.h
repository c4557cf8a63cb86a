// Samples of a mesh or of a cloud.
#pragma once

#include <cstdint>
#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

// Poisson-disk samples inside `box`. Of a cloud: its points, thinned in random order to the same
// spacing, without normal (zero) and with face -1.
std::vector<SurfaceSample> SamplesInBox(const TriangleMesh& mesh, const BoundingBox& box,
                                        double spacing_m, std::uint64_t seed);

// `count` samples with normals for ICP, uniform by area; of a cloud: random points of it (all when
// there are fewer), with the normal of the plane through their nearest neighbours, of either sign.
std::vector<SurfaceSample> SamplesWithNormals(const TriangleMesh& mesh, std::size_t count,
                                              std::uint64_t seed);

}  // namespace colmap_ext
