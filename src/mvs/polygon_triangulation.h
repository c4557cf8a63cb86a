#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// Corners (positions in `polygon`) of each triangle.
using PolygonTriangles = std::vector<Eigen::Vector3i>;

// The triangulation of a (nearly) convex polygon, in order of positive area, whose smallest
// triangle height is largest; among these the rest is optimal in the same way part by part. Empty
// when every triangulation has a triangle of less than `min_area`.
PolygonTriangles TriangulatePolygon(const std::vector<Eigen::Vector2d>& polygon, double min_area);

}  // namespace colmap_ext
