// A whole small workspace with exact truth: a house on a lawn, photographed from a circle.
#pragma once

#include <filesystem>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct MadeUpHouse {
  TriangleMesh mesh;  // lawn 16 m x 16 m at z = 0, house 4 m x 6 m x 3 m with a roof to 5 m
  std::vector<Eigen::Vector3d> vertex_color;  // RGB 0 … 1
};
MadeUpHouse MakeHouse();

// Photos of iteration i of MakeWorkspace, all of them looking at (0, 0, 1.5).
inline int PhotosOfIteration(int iteration) { return 6 + 4 * iteration; }
inline constexpr PinholeCamera kHouseCamera = {480, 320, 400, 400, 240, 160};

// Writes summary.json, state.json, images/ (JPEG) and, of each iteration, sparse/, surface.ply,
// coverage.ply and .json, views.json, path.json, frame.json, fused.ply, overlays.json and a
// picture.
void MakeWorkspace(const std::filesystem::path& root, int iterations);

}  // namespace colmap_ext
