// Proofs that straight lines keep their distance from a mesh, everywhere and not only at samples.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "colmap_ext/geom/ray_scene.h"

namespace colmap_ext {

// Distances to a surface change by no more than one moves (they are 1-Lipschitz): between two
// points a and b with distances d_a and d_b, no point of the segment is nearer to the surface than
//   (d_a + d_b - |a - b|) / 2.
// Both functions below halve segments until this bound says enough, so they look at every point of
// the line. 1 mm is taken off for the rounding of the single-precision mesh.

// Proves that every point of the segment is at least `required_m` (>= 0) from the surface. Gives
// up, returning false, where a point is nearer than required_m + tolerance_m (tolerance_m > 1 mm):
// so true is always right, and false only wrong within the tolerance.
bool ProveClearance(const RayScene& scene, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double required_m, double tolerance_m);

// A proved lower bound of the least distance from the polyline to the surface, at most
// `tolerance_m` below it (plus 1 mm). Distances beyond `max_m` count as max_m. Not negative. An
// empty polyline has max_m.
double ProvedMinClearance(const RayScene& scene, const std::vector<Eigen::Vector3d>& polyline,
                          double tolerance_m, double max_m);

}  // namespace colmap_ext
