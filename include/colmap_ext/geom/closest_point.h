// Nearest point of a mesh, in double precision (RayScene answers in float32, and only the
// distance): what registration and error measures need. Nearest points of a cloud: point_index.h.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct ClosestPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance = 0;
  int face = -1;
};

// Bounding-box tree over the triangles of a mesh. Immutable after construction; all queries may be
// called from many threads, and have one answer whatever their number.
class ClosestPointIndex {
 public:
  // Over the surface of `mesh` (its faces; vertices alone are no surface).
  explicit ClosestPointIndex(const TriangleMesh& mesh);

  // The nearest point closer than `max_distance`; nullopt when there is none.
  std::optional<ClosestPoint> Find(
      const Eigen::Vector3d& query,
      double max_distance = std::numeric_limits<double>::infinity()) const;

  std::size_t NumFaces() const { return order_.size(); }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0;  // leaf: first position in order_; inner node: index of the right child
    int count = 0;  // leaf: number of faces; 0 for an inner node, whose left child is next
  };

  void Build(std::vector<Eigen::Vector3d>* centroids, int begin, int end);
  std::array<Eigen::Vector3d, 3> Corners(int face) const;

  TriangleMesh mesh_;
  std::vector<int> order_;  // faces, sorted by leaf
  std::vector<Node> nodes_;
};

// Point of the triangle (a, b, c) nearest to `query`; degenerate triangles are segments or points.
Eigen::Vector3d ClosestPointOnTriangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace colmap_ext
