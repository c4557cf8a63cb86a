// What a camera sees of a surface. One engine serves coverage and next-best-view planning.
#pragma once

#include <Eigen/Core>
#include <string>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

struct VisibilityOptions {
  // Metres, >= 0. The ray from the camera ends this far above the surface (along the normal), and
  // what it meets in the last epsilon_m does not count: the surface's own roughness hides nothing.
  // 0: chosen from the mesh, min(median edge, 0.2 % of the diagonal of its bounds).
  double epsilon_m = 0;
  // Largest angle between the normal and the direction to the camera, degrees, (0, 90].
  double max_incidence_deg = 80;
  // Points nearer to the border of the image than this are not seen, px, >= 0.
  double border_px = 4;

  std::string Check() const;
};

// Immutable after construction; queries may be made from many threads.
class VisibilityEngine {
 public:
  // `mesh` in the world. Throws UsageError when options.Check() complains.
  VisibilityEngine(const TriangleMesh& mesh, const VisibilityOptions& options);

  // In front of the camera, inside its image, facing it, and nothing of the mesh in between.
  // `normal`: unit, outwards.
  bool IsVisible(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                 const Eigen::Vector3d& position, const Eigen::Vector3d& normal) const;

  // The same without the occlusion test (cheap; true is necessary for IsVisible).
  bool IsInView(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                const Eigen::Vector3d& position, const Eigen::Vector3d& normal) const;

  // Only the occlusion test: nothing lies between `camera_center` and the point.
  bool IsUnoccluded(const Eigen::Vector3d& camera_center, const Eigen::Vector3d& position,
                    const Eigen::Vector3d& normal) const;

  const RayScene& ray_scene() const { return ray_scene_; }
  double epsilon_m() const { return epsilon_m_; }

 private:
  RayScene ray_scene_;
  double epsilon_m_ = 0;
  double min_cos_incidence_ = 0;
  double border_px_ = 0;
};

}  // namespace colmap_ext
