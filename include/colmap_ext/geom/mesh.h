#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace colmap_ext {

// Triangles in one frame (world unless the name says otherwise), metres. Faces index vertices and
// are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
};

using BoundingBox = Eigen::AlignedBox3d;

BoundingBox BoundsOf(const TriangleMesh& mesh);
// Unit normal; zero vector for a degenerate face.
Eigen::Vector3d FaceNormal(const TriangleMesh& mesh, std::size_t face);
double FaceArea(const TriangleMesh& mesh, std::size_t face);  // m²
// Area-weighted unit normals, one a vertex.
std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh);

// A point on a mesh.
struct SurfaceSample {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;  // unit, of its face
  int face = 0;
};

// `count` points uniform by area (stratified over the accumulated area), from `seed`. Same input,
// same output. Degenerate faces get none.
std::vector<SurfaceSample> SampleUniformly(const TriangleMesh& mesh, std::size_t count,
                                           std::uint64_t seed);

// Poisson-disk samples: no two nearer than `radius_m`, and no point of the surface further than
// 2 radius_m from one (dart throwing over a dense uniform sampling). Faces for which
// `face_mask[face] == false` are left out when the mask is not empty.
std::vector<SurfaceSample> SamplePoissonDisk(const TriangleMesh& mesh, double radius_m,
                                             std::uint64_t seed,
                                             const std::vector<bool>& face_mask = {});

// Points in random order, each kept when no kept one is nearer than `radius_m`: indices of the kept
// ones. Same input, same output.
std::vector<std::size_t> ThinPoints(const std::vector<Eigen::Vector3d>& points, double radius_m,
                                    std::uint64_t seed);

}  // namespace colmap_ext
