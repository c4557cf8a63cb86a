// Rays and distances against a triangle mesh (Embree). One engine for rendering, visibility and
// clearance.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct RayHit {
  double distance_m = 0;  // along the unit direction
  int face = 0;
  double u = 0, v = 0;  // hit = (1 - u - v) v0 + u v1 + v v2
};

// Immutable after construction; all queries may be called from many threads.
class RayScene {
 public:
  // Copies the geometry as float32. An empty mesh is allowed: nothing is ever hit.
  explicit RayScene(const TriangleMesh& mesh_in_world);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  // First hit with distance in (min_m, max_m). `direction` must be of unit length.
  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double min_m, double max_m) const;

  // Whether anything lies strictly between the points, ignoring `epsilon_m` at either end.
  bool IsOccluded(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double epsilon_m) const;

  // Distance from `point` to the nearest surface point, or `max_m` when there is none nearer.
  double DistanceToSurface(const Eigen::Vector3d& point, double max_m) const;

  std::size_t NumFaces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
