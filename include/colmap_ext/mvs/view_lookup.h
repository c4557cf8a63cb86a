// What the mesh of one view says at a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// The triangle that covers each pixel's centre, -1 where there is none (CV_32SC1, of the camera's
// size).
cv::Mat1i TriangleIdMap(const ViewMesh& mesh);

// The planes of a view's triangles, and the way from a pixel to its triangle. Refers to the mesh's
// image plane only through `triangle_at`, which stays valid while depths change.
struct ViewLookup {
  ViewLookup() = default;  // of no view: nothing may be asked of it
  // With an empty `triangle_at` every pixel is outside.
  ViewLookup(const ViewMesh& mesh, cv::Mat1i triangle_at);

  // Triangle at a pixel position; -1 outside.
  int TriangleAt(const Eigen::Vector2d& pixel) const {
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < triangle_at.cols &&
          pixel.y() < triangle_at.rows)) {
      return -1;
    }
    return triangle_at(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
  }
  // Inverse depth of the plane of triangle `t` on the ray of `pixel`.
  double InverseDepth(int t, const Eigen::Vector2d& pixel) const {
    return plane_in_cam[static_cast<std::size_t>(t)].dot(camera.Ray(pixel));
  }
  // Point of the plane of triangle `t` on the ray of `pixel`; inverse depth there must be > 0.
  Eigen::Vector3d PointInWorld(int t, const Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d ray = camera.Ray(pixel);
    return world_from_cam * (ray / plane_in_cam[static_cast<std::size_t>(t)].dot(ray));
  }

  PinholeCamera camera;
  Rigid3d cam_from_world;
  Rigid3d world_from_cam;
  Eigen::Matrix3d cam_from_world_rotation = Eigen::Matrix3d::Identity();
  cv::Mat1i triangle_at;
  // Triangle t lies in the plane {X in the camera frame: plane_in_cam[t] · X = 1}: the inverse
  // depth on the ray r (z = 1) is plane_in_cam[t] · r.
  std::vector<Eigen::Vector3d> plane_in_cam;
  std::vector<Eigen::Vector3d> normal_in_world;  // unit, facing the camera
};

}  // namespace colmap_ext
