#pragma once

#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

// The reconstructed surface with its Poisson signal.
struct Surface {
  TriangleMesh mesh;  // world
  // One a vertex: the local spacing (metres) of the points that support the surface there (computed
  // as surface/poisson.h says). SMALL spacing = STRONG signal.
  std::vector<double> sample_spacing_m = {};
  // One a vertex, or none where it is not known (files of before): how far the points around lie
  // from the surface, metres, RMS along its normal (surface/poisson.h).
  std::vector<double> scatter_m = {};
  std::vector<Eigen::Vector3d> color = {};  // RGB 0 … 1, one a vertex
};

}  // namespace colmap_ext
