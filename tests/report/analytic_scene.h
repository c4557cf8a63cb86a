// A red unit sphere before a blue wall, seen from the origin looking north.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/report/mesh_picture.h"

namespace colmap_ext {

struct SphereAndWall {
  static constexpr double kSphereDistance = 6;  // of its centre
  static constexpr double kWallDistance = 9;    // the wall: x, z in [-3.5, 3.5]

  TriangleMesh mesh;
  std::vector<Rgb> face_colors;

  SphereAndWall() {
    AddSphere(96);
    face_colors.assign(mesh.faces.size(), Rgb(0.9f, 0.1f, 0.1f));
    const int first = static_cast<int>(mesh.vertices.size());
    for (const auto& [x, z] : {std::pair{-3.5, -3.5}, {3.5, -3.5}, {3.5, 3.5}, {-3.5, 3.5}}) {
      mesh.vertices.emplace_back(x, kWallDistance, z);
    }
    mesh.faces.emplace_back(first, first + 1, first + 2);
    mesh.faces.emplace_back(first, first + 2, first + 3);
    face_colors.resize(mesh.faces.size(), Rgb(0.1f, 0.1f, 0.9f));
  }

 private:
  void AddSphere(int n) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i < n; ++i) {
        const double u = 2 * M_PI * i / n, v = M_PI * j / n;
        mesh.vertices.emplace_back(std::sin(v) * std::cos(u),
                                   kSphereDistance + std::sin(v) * std::sin(u), std::cos(v));
      }
    }
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const int a = j * n + i, b = j * n + (i + 1) % n;
        if (j < n - 1) mesh.faces.emplace_back(a, a + n, b + n);
        if (j > 0) mesh.faces.emplace_back(a, b + n, b);
      }
    }
  }
};

// Camera in the origin, looking north, level; focal length equal to the width.
inline PictureCamera LookingNorth(const cv::Size& size) {
  PictureCamera camera;
  const double focal = size.width;
  camera.camera = {size.width, size.height, focal, focal, 0.5 * size.width, 0.5 * size.height};
  camera.cam_from_world = CamFromWorld(Eigen::Vector3d::Zero(), {0, 0});
  return camera;
}

}  // namespace colmap_ext
