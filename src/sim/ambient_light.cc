#include "sim/ambient_light.h"

#include <algorithm>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/parallel.h"
#include "sim/face_visibility.h"

namespace colmap_ext {
namespace {

constexpr double kNearPart = 0.12;  // of the model's extent: closer surfaces give less light back

// Where rays of each vertex start: drawn a little into the faces around it, off edges that it may
// share with other walls.
std::vector<Eigen::Vector3d> RayOrigins(const TexturedScene& scene, double offset_m) {
  const auto& mesh = scene.mesh;
  std::vector<Eigen::Vector3d> sum(mesh.vertices.size(), Eigen::Vector3d::Zero());
  std::vector<int> count(mesh.vertices.size(), 0);
  for (const auto& face : mesh.faces) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) center += mesh.vertices[static_cast<std::size_t>(face[k])] / 3;
    for (int k = 0; k < 3; ++k) {
      sum[static_cast<std::size_t>(face[k])] += center;
      ++count[static_cast<std::size_t>(face[k])];
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const Eigen::Vector3d inner =
        count[i] > 0 ? Eigen::Vector3d(sum[i] / count[i]) : mesh.vertices[i];
    sum[i] = mesh.vertices[i] + 0.15 * (inner - mesh.vertices[i]) +
             offset_m * scene.vertex_normals[i].cast<double>();
  }
  return sum;
}

}  // namespace

std::vector<AmbientLight> ComputeAmbientLight(const TexturedScene& scene, int rays) {
  std::vector<AmbientLight> light(scene.mesh.vertices.size());
  if (rays == 0) {
    for (std::size_t i = 0; i < light.size(); ++i) {
      light[i].sky = 0.5F + 0.5F * scene.vertex_normals[i].z();
      light[i].bounce = 1 - light[i].sky;
    }
    return light;
  }
  const RayScene ray_scene(scene.mesh);
  BoundingBox model = BoundsOf(scene.Truth().model);
  if (model.isEmpty()) model = BoundsOf(scene.mesh);
  const double near_m = std::max(1e-3, kNearPart * model.sizes().minCoeff());
  const double far_m = 20 * model.diagonal().norm();
  const auto origins = RayOrigins(scene, 1e-4 * model.diagonal().norm());
  const auto directions = HemisphereDirections(rays, true);
  ParallelFor(light.size(), [&](std::size_t i) {
    const Eigen::Matrix3d rotation =
        RotationFromZ(scene.vertex_normals[i].cast<double>().normalized());
    double sky = 0, bounce = 0;
    for (const auto& local : directions) {
      const Eigen::Vector3d direction = rotation * local;
      const auto hit = ray_scene.Intersect(origins[i], direction, 0, far_m);
      // Below the horizon there is always ground, even where the scene ends.
      if (hit.has_value()) bounce += std::min(1.0, hit->distance_m / near_m);
      if (!hit.has_value()) (direction.z() > 0 ? sky : bounce) += 1;
    }
    light[i].sky = static_cast<float>(sky / rays);
    light[i].bounce = static_cast<float>(bounce / rays);
  });
  return light;
}

}  // namespace colmap_ext
