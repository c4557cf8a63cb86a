#include "colmap_ext/mvs/view_lookup.h"

#include "mvs/raster.h"

namespace colmap_ext {
namespace {

// n with n · ray_k = inverse_depth_k at the three corners.
Eigen::Vector3d PlaneInCam(const ViewMesh& mesh, std::size_t t) {
  Eigen::Matrix3d rays;
  for (int k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(mesh.image.triangles[t][k]);
    rays.row(k) = mesh.camera.Ray(mesh.image.vertices_px[v]).transpose();
  }
  return rays.inverse() * mesh.inverse_depth[t];
}

}  // namespace

cv::Mat1i TriangleIdMap(const ViewMesh& mesh) {
  return RasterizeTriangleIds(mesh.image, mesh.camera.width, mesh.camera.height);
}

ViewLookup::ViewLookup(const ViewMesh& mesh, cv::Mat1i triangle_ids)
    : camera(mesh.camera),
      cam_from_world(mesh.cam_from_world),
      world_from_cam(Inverse(mesh.cam_from_world)),
      cam_from_world_rotation(mesh.cam_from_world.rotation.toRotationMatrix()),
      triangle_at(std::move(triangle_ids)) {
  plane_in_cam.reserve(mesh.inverse_depth.size());
  normal_in_world.reserve(mesh.inverse_depth.size());
  for (std::size_t t = 0; t < mesh.inverse_depth.size(); ++t) {
    plane_in_cam.push_back(PlaneInCam(mesh, t));
    // plane · X = 1 > 0 in front of the camera, so the plane's vector points away from it.
    const Eigen::Vector3d normal_in_cam = -plane_in_cam.back().normalized();
    normal_in_world.push_back(cam_from_world_rotation.transpose() * normal_in_cam);
  }
}

}  // namespace colmap_ext
