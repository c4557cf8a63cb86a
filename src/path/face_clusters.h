#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

// The faces of a surface in groups of neighbours, each in a ball: what is out of the picture or
// hidden is found out by group. Faces of a group share its vertices.
struct FaceClusters {
  struct Cluster {
    Eigen::Vector3d center;
    double radius_m = 0;
    std::uint32_t first_vertex = 0, end_vertex = 0;  // in `vertices`
    std::uint32_t first_face = 0, end_face = 0;      // in `faces`
  };
  struct Face {
    std::array<std::uint32_t, 3> vertices;  // counted from the first one of the cluster
    bool is_confident = true;
  };

  // `confident`: one a face, or empty: all are. `faces_a_cluster`: at most, >= 1.
  FaceClusters(const TriangleMesh& surface, const std::vector<bool>& confident,
               std::size_t faces_a_cluster = 24);

  std::vector<Eigen::Vector3d> vertices;
  std::vector<Face> faces;
  std::vector<Cluster> clusters;
};

}  // namespace colmap_ext
