// The fused cloud with one point a voxel, side and surface, and with what each photo gave to it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/oriented_points.h"

namespace colmap_ext {

struct PhotoWeight {
  int photo_index = -1;
  double weight = 0;  // summed confidence
};

// All vectors but the last two have one entry a point.
struct ThinnedCloud {
  std::vector<Eigen::Vector3d> positions;  // confidence-weighted means
  std::vector<Eigen::Vector3d> normals;    // unit
  std::vector<Eigen::Vector3d> colors;     // RGB 0 … 1
  std::vector<double> squared_scatter;     // m², of the merged points along the normal, weighted
  // Point i owns photo_weights[photo_begin[i]] … photo_weights[photo_begin[i + 1] - 1].
  std::vector<std::size_t> photo_begin;
  std::vector<PhotoWeight> photo_weights;
};

// Points of `points` inside `box` with confidence >= min_confidence and a normal. Throws Error
// naming the first point that is not finite.
std::vector<std::size_t> UsablePoints(const OrientedPoints& points, const BoundingBox& box,
                                      double min_confidence);

// Rough area of the surface that the points `selected` lie on, m²: occupied cells of a grid of
// `cell_m`.
double EstimateArea(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                    double cell_m);

// Merges the points `selected` that share a voxel of edge `voxel_m` and the main direction of their
// normals (six: both sides of a thin wall stay apart). Depends on the set of points only through
// the order of sums: same input, same output.
ThinnedCloud ThinCloud(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                       double voxel_m);

}  // namespace colmap_ext
