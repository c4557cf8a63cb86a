// Shapes with known answers.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// A rectangle `origin` + [0, 1] u + [0, 1] v in n x n cells of two triangles, normal u x v.
inline void AppendRectangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& u,
                            const Eigen::Vector3d& v, int n, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) mesh->vertices.push_back(origin + u * i / n + v * j / n);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = first + j * (n + 1) + i;
      mesh->faces.emplace_back(a, a + 1, a + n + 2);
      mesh->faces.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
}

// Closed box with `corner` at its smallest coordinates.
inline void AppendBox(const Eigen::Vector3d& corner, const Eigen::Vector3d& size, int n,
                      TriangleMesh* mesh) {
  const Eigen::Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  AppendRectangle(corner, y, x, n, mesh);
  AppendRectangle(corner + z, x, y, n, mesh);
  AppendRectangle(corner, x, z, n, mesh);
  AppendRectangle(corner + y, z, x, n, mesh);
  AppendRectangle(corner, z, y, n, mesh);
  AppendRectangle(corner + x, y, z, n, mesh);
}

// A house with a tower: no symmetry, so that every similarity has one answer.
inline TriangleMesh House(int n = 12) {
  TriangleMesh mesh;
  AppendBox({0, 0, 0}, {8, 5, 4}, n, &mesh);
  AppendBox({8, 1, 0}, {2.5, 2, 9}, n, &mesh);
  return mesh;
}

inline Sim3d MakeSim3(double scale, double angle_rad, const Eigen::Vector3d& axis,
                      const Eigen::Vector3d& translation) {
  return {scale, Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis.normalized())), translation};
}

}  // namespace colmap_ext
