#include "colmap_ext/scene/view_mesh.h"

#include <Eigen/Geometry>

namespace colmap_ext {

Eigen::Vector3d CornerInWorld(const ViewMesh& mesh, int t, int k) {
  const auto triangle = static_cast<std::size_t>(t);
  const auto vertex = static_cast<std::size_t>(mesh.image.triangles[triangle][k]);
  const Eigen::Vector3d ray = mesh.camera.Ray(mesh.image.vertices_px[vertex]);
  return Inverse(mesh.cam_from_world) * (ray / mesh.inverse_depth[triangle][k]);
}

Eigen::Vector3d TriangleNormalInWorld(const ViewMesh& mesh, int t) {
  const Eigen::Vector3d a = CornerInWorld(mesh, t, 0);
  const Eigen::Vector3d b = CornerInWorld(mesh, t, 1);
  const Eigen::Vector3d c = CornerInWorld(mesh, t, 2);
  // The image's y points down, so that the corners turn clockwise for the camera.
  return (c - a).cross(b - a).normalized();
}

}  // namespace colmap_ext
