// The superpixel mesh of one photo and its depths (paper, Sec. "Linear Dense MVS").
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// Triangulated superpixels of a photo in the image plane.
struct ImageMesh {
  std::vector<Eigen::Vector2d> vertices_px;  // COLMAP's pixel convention
  std::vector<Eigen::Vector3i> triangles;    // vertex indices, positive area in (x right, y down)
  // neighbors[t][k]: the triangle across the edge opposite to vertex k of t; -1 at the border.
  std::vector<Eigen::Vector3i> neighbors;
  std::vector<int> superpixel;  // polygon of each triangle, 0 … num_superpixels - 1
  int num_superpixels = 0;
  std::vector<Eigen::Vector3f> mean_bgr;  // mean colour of each triangle's superpixel, 0 … 255
};

// A mesh with depth. Per triangle three inverse depths 1/z (z along the optical axis, metres⁻¹),
// one a corner: two triangles may disagree at a shared vertex (the paper's discontinuous
// parameterisation).
struct ViewMesh {
  int photo_index = -1;  // in the PhotoSet
  PinholeCamera camera;
  Rigid3d cam_from_world;
  ImageMesh image;
  std::vector<Eigen::Vector3d> inverse_depth;  // size = triangles
  std::vector<float> confidence;               // Γ of the paper's confidence equation, 0 … 1
  std::vector<std::uint8_t> supported;  // 0: no SfM point's region reaches it; marked, not invented
};

// Corner `k` of triangle `t` in the world. Inverse depths are > 0 for supported triangles.
Eigen::Vector3d CornerInWorld(const ViewMesh& mesh, int t, int k);
// Unit normal in the world, facing the camera.
Eigen::Vector3d TriangleNormalInWorld(const ViewMesh& mesh, int t);

}  // namespace colmap_ext
