// How densely, and how closely, points support a surface.
#pragma once

#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "surface/thinned_cloud.h"

namespace colmap_ext {

// One entry a vertex, metres, all at most `max_spacing_m`.
struct SupportSignal {
  // Spacing of all points, whatever their normals: how far from any support a vertex is.
  std::vector<double> spacing;
  // Of points whose normals agree with the vertex's, without the photo that gives most (poisson.h).
  std::vector<double> independent_spacing;
  // RMS distance of the points from the vertex along its normal (poisson.h).
  std::vector<double> scatter;
};

// Of the 24 points nearest to each vertex of `mesh`; those whose normals differ by more than 60°
// from the vertex's do not support it.
SupportSignal ComputeSupportSignal(const ThinnedCloud& cloud, const TriangleMesh& mesh,
                                   double max_spacing_m);

}  // namespace colmap_ext
