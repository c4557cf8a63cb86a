// Which faces of a scene can be seen from outside.
#pragma once

#include <vector>

#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

// True for faces that see the sky, or see ground that sees the sky, along at least one of a fixed
// set of rays from four of their points (about 200 rays a face; what all of them miss is hidden for
// practical purposes). Ground faces are always true.
std::vector<bool> FindVisibleFaces(const TriangleMesh& mesh,
                                   const std::vector<int>& object_of_face);

// Removes the faces whose `keep` is false, and vertices that no face uses any more.
void KeepFaces(const std::vector<bool>& keep, TexturedScene* scene);

// `count` unit directions spread evenly over the half sphere around +z.
std::vector<Eigen::Vector3d> HemisphereDirections(int count, bool cosine_weighted);

// A rotation that takes +z to `normal` (unit), the same for equal normals.
Eigen::Matrix3d RotationFromZ(const Eigen::Vector3d& normal);

}  // namespace colmap_ext
