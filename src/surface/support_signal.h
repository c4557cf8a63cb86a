// How densely points support a surface.
#pragma once

#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "surface/thinned_cloud.h"

namespace colmap_ext {

// One entry a vertex, metres, both at most `max_spacing_m`.
struct SupportSpacing {
  // Of all points, whatever their normals: how far from any support a vertex is.
  std::vector<double> all;
  // Of points whose normals agree with the vertex's, without the photo that gives most (poisson.h).
  std::vector<double> independent;
};

// Spacing of the points around each vertex of `mesh`, from its 24 nearest points; those whose
// normals differ by more than 60° from the vertex's do not support it.
SupportSpacing ComputeSupportSpacing(const ThinnedCloud& cloud, const TriangleMesh& mesh,
                                     double max_spacing_m);

}  // namespace colmap_ext
