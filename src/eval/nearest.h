// Nearest point of a mesh, or of a cloud where there are no faces.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "colmap_ext/geom/closest_point.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/point_index.h"

namespace colmap_ext {

struct NearestPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance = 0;
  int face = -1;  // of the mesh; -1 where vertices are searched
};

class NearestFinder {
 public:
  // `to_vertices`: measure to the vertices although there are faces.
  NearestFinder(const TriangleMesh& mesh, bool to_vertices);

  // nullopt when nothing is nearer than `max_distance`. May be called from many threads.
  std::optional<NearestPoint> Find(
      const Eigen::Vector3d& query,
      double max_distance = std::numeric_limits<double>::infinity()) const;

  // Distance of each point, in parallel. There must be something to find.
  std::vector<double> Distances(const std::vector<Eigen::Vector3d>& points) const;

 private:
  std::vector<Eigen::Vector3d> vertices_;  // empty when faces are searched
  std::variant<ClosestPointIndex, PointIndex> index_;
};

}  // namespace colmap_ext
