// How many square pixels of a photo a square metre of surface gets.
#pragma once

#include <Eigen/Core>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// The paper's projection ratio γ_p(v) = a_p(v) / A_p (Sec. "Coverage Evaluation"), px² / m², for a
// disk at `position` (world) with unit outward `normal` whose area A_p goes to zero:
//
//   γ = fx fy · max(0, n·(c − p)) / z³
//
// with c the centre of the camera and z the depth of p along its optical axis. It is the
// determinant of the derivative of (fx x/z, fy y/z) on the plane of the disk. For a disk in the
// middle of the image at distance d, seen at the angle θ from its normal, it is fx fy cosθ / d².
// 0 when the point is not in front of the camera or the disk faces away. Neither the image's border
// nor occlusion is looked at: see VisibilityEngine.
inline double ProjectionRatio(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                              const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d position_in_cam = cam_from_world * position;
  const double depth = position_in_cam.z();
  if (depth <= 0) return 0;
  // n·(c − p), written in the camera's frame where c is the origin.
  const double facing = -(cam_from_world.rotation * normal).dot(position_in_cam);
  if (facing <= 0) return 0;
  return camera.fx * camera.fy * facing / (depth * depth * depth);
}

// γ of a surface seen face-on in the middle of the image at a ground sampling distance of
// `gsd_mm` millimetres a pixel: 1 / gsd², px² / m².
inline double ProjectionRatioOfGroundSamplingDistance(double gsd_mm) {
  return 1e6 / (gsd_mm * gsd_mm);
}

}  // namespace colmap_ext
