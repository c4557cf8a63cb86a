// The border to Open3D: its headers are seen by open3d_bridge.cc only.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "surface/thinned_cloud.h"

namespace colmap_ext {

struct PoissonMesh {
  TriangleMesh mesh;                    // world
  std::vector<Eigen::Vector3d> colors;  // RGB 0 … 1, one a vertex
};

// Screened Poisson of the cloud, one thread, an octree of `depth` levels whose finest cells have
// edges of `cell_m` (the root must hold the cloud: 2^depth cell_m >= its extent).
PoissonMesh RunPoisson(const ThinnedCloud& cloud, int depth, double cell_m);

struct Neighbor {
  std::size_t index = 0;
  double squared_distance = 0;
};

// Nearest points of a cloud; queries may be made from many threads.
class NeighborSearch {
 public:
  // Throws Error for an empty cloud.
  explicit NeighborSearch(const std::vector<Eigen::Vector3d>& points);
  ~NeighborSearch();

  // The `count` nearest points (fewer when there are fewer), nearest first.
  std::vector<Neighbor> Nearest(const Eigen::Vector3d& point, int count) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
