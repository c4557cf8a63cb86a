// Walls, balls and cameras whose coverage is known by geometry.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

inline PinholeCamera TestCamera() { return {640, 368, 467.0, 467.0, 320.0, 184.0}; }

// A photo from `position`, heading `yaw_deg` (0: north), level unless pitch is given.
inline PosedPhoto PhotoAt(const Eigen::Vector3d& position, double yaw_deg, double pitch_deg = 0) {
  PosedPhoto photo;
  photo.camera = TestCamera();
  photo.cam_from_world = CamFromWorld(position, {DegToRad(yaw_deg), DegToRad(pitch_deg)});
  photo.name = "photo.jpg";
  return photo;
}

// A photo from `position` towards `target`.
inline PosedPhoto PhotoTowards(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d d = (target - position).normalized();
  return PhotoAt(position, RadToDeg(std::atan2(d.x(), d.y())), RadToDeg(std::asin(d.z())));
}

// Parallelogram of n x n quads; faces turn towards side_u x side_v.
inline void AppendPanel(const Eigen::Vector3d& corner, const Eigen::Vector3d& side_u,
                        const Eigen::Vector3d& side_v, int n, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) mesh->vertices.push_back(corner + side_u * i / n + side_v * j / n);
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = first + i * (n + 1) + j;
      mesh->faces.emplace_back(a, a + n + 1, a + n + 2);
      mesh->faces.emplace_back(a, a + n + 2, a + 1);
    }
  }
}

// The wall y = 0, x in [-5, 5], z in [0, 6], facing south (-y). No signal unless given.
inline Surface Wall() {
  Surface surface;
  AppendPanel({-5, 0, 0}, {10, 0, 0}, {0, 0, 6}, 40, &surface.mesh);
  return surface;
}

inline Surface WithSignal(Surface surface, double spacing_m) {
  surface.sample_spacing_m.assign(surface.mesh.vertices.size(), spacing_m);
  return surface;
}

inline TriangleMesh Ball(const Eigen::Vector3d& center, double radius, int n) {
  TriangleMesh mesh;
  for (int i = 0; i <= n; ++i) {
    const double polar = std::numbers::pi * i / n;
    for (int j = 0; j < 2 * n; ++j) {
      const double around = std::numbers::pi * j / n;
      mesh.vertices.push_back(center + radius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                                std::sin(polar) * std::sin(around),
                                                                std::cos(polar)));
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < 2 * n; ++j) {
      const int a = i * 2 * n + j, b = i * 2 * n + (j + 1) % (2 * n);
      mesh.faces.emplace_back(a, a + 2 * n, b + 2 * n);
      mesh.faces.emplace_back(a, b + 2 * n, b);
    }
  }
  return mesh;
}

inline RegionOfInterest Everything() {
  return {BoundingBox(Eigen::Vector3d::Constant(-1000), Eigen::Vector3d::Constant(1000))};
}

}  // namespace colmap_ext
