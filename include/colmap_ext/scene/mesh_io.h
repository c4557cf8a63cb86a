// Meshes and the reconstructed surface as PLY files that MeshLab and CloudCompare open. Positions
// are written as float64: what a stage reads back is what the stage before had in memory.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/surface.h"

namespace colmap_ext {

struct ColoredMesh {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> color;  // RGB 0 … 1, one a vertex; empty when the file has none
};

// Faces with more than three corners are split into fans. A file without faces gives a mesh without
// faces. Throws Error naming the file, and the vertex or face: not a PLY file, truncated, a
// position that is not finite, a corner that is no vertex, a face of fewer than three corners.
TriangleMesh ReadMesh(const std::filesystem::path& path);
ColoredMesh ReadColoredMesh(const std::filesystem::path& path);

// `color`: one a vertex (rounded to 8 bit a channel) or empty. Throws Error when a vertex is not
// finite, a face names no vertex, or the number of colours is wrong; nothing is written then.
void WriteMesh(const TriangleMesh& mesh, const std::filesystem::path& path);
void WriteMesh(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& color,
               const std::filesystem::path& path);

// A mesh with the vertex property sample_spacing_m (float64) and colours. Colours come back rounded
// to 1/255, all else exactly. A surface without colours is written and read without.
Surface ReadSurface(const std::filesystem::path& path);
void WriteSurface(const Surface& surface, const std::filesystem::path& path);

}  // namespace colmap_ext
