// Where a simulated drone flies: the scene as the drone meets it.
#pragma once

#include <Eigen/Core>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/sim/vehicle_motion.h"

namespace colmap_ext {

class DroneSite {
 public:
  explicit DroneSite(const TexturedScene& scene);

  // A place to take off from: on the ground under the open sky, up to 8 m from the model and clear
  // of everything else, as near to the model's middle as that allows. Throws Error when there is
  // none.
  Eigen::Vector3d DefaultHome() const;
  // The place on the surface at (x, y). Throws Error when there is none.
  Eigen::Vector3d OnSurface(double x, double y) const;

  // Surface below a position; far outside of the scene its lowest z. Refers to this object.
  VehicleMotion::GroundHeight Ground() const;
  // Distance to the model (without ground), at most `max_m`.
  double Clearance(const Eigen::Vector3d& position, double max_m) const;

 private:
  BoundingBox bounds_, model_bounds_;
  RayScene scene_, model_;
};

}  // namespace colmap_ext
