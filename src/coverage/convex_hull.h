#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// Convex hull of points in the plane, counter-clockwise; fewer than three corners when the points
// are collinear.
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points);

// Whether the point lies in a convex counter-clockwise polygon, border included.
bool IsInside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& point);

}  // namespace colmap_ext
