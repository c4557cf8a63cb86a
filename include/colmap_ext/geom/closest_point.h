// Nearest point of a mesh or a cloud, in double precision (RayScene answers in float32, and only
// the distance): what registration and error measures need.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct ClosestPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance = 0;
  int primitive = -1;  // face index, or vertex index when the index was built over vertices
};

// Bounding-box tree over the triangles of a mesh, or over points. Immutable after construction; all
// queries may be called from many threads, and have one answer whatever their number.
class ClosestPointIndex {
 public:
  // Over the surface of `mesh`. Faces index its vertices.
  static ClosestPointIndex OfSurface(const TriangleMesh& mesh);
  // Over points alone.
  static ClosestPointIndex OfPoints(const std::vector<Eigen::Vector3d>& points);

  // The nearest point closer than `max_distance`; nullopt when there is none.
  std::optional<ClosestPoint> Find(
      const Eigen::Vector3d& query,
      double max_distance = std::numeric_limits<double>::infinity()) const;

  std::size_t NumPrimitives() const { return order_.size(); }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0;  // leaf: first position in order_; inner node: index of the right child
    int count = 0;  // leaf: number of primitives; 0 for an inner node, whose left child is next
  };

  ClosestPointIndex(std::vector<Eigen::Vector3d> vertices, std::vector<Eigen::Vector3i> faces);
  void Build(std::vector<Eigen::Vector3d>* centroids, int begin, int end);
  Eigen::Vector3d ClosestOnPrimitive(int primitive, const Eigen::Vector3d& query) const;

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Eigen::Vector3i> faces_;  // empty: the primitives are the vertices
  std::vector<int> order_;              // primitives, sorted by leaf
  std::vector<Node> nodes_;
};

// Point of the triangle (a, b, c) nearest to `query`; degenerate triangles are segments or points.
Eigen::Vector3d ClosestPointOnTriangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace colmap_ext
