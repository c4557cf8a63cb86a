// Triangulates planar polygons with holes into well-shaped triangles of bounded size.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

struct PlanarMesh {
  std::vector<Eigen::Vector2d> vertices;
  std::vector<bool> on_border;         // one a vertex: on the outline or on a hole's
  std::vector<Eigen::Vector3i> faces;  // counter-clockwise
};

// `outer` is simple; holes are simple, disjoint and inside it (any orientation). Edges of the
// result are at most about `max_edge_m` long. Borders are split on their straight lines only.
PlanarMesh MeshPolygon(const std::vector<Eigen::Vector2d>& outer,
                       const std::vector<std::vector<Eigen::Vector2d>>& holes, double max_edge_m);

}  // namespace colmap_ext
