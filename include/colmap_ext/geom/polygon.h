// Polygons in the plane: fences, regions of interest, no-fly zones.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// Corners in order, in one unit of length (metres of the world's x and y nearly everywhere); the
// last corner is joined to the first and does not repeat it.
using PolygonRing = std::vector<Eigen::Vector2d>;

// Even-odd rule, so that rings that cross themselves have a meaning. On the border the answer may
// be either; ask DistanceToBorder where that matters. A ring of fewer than three corners holds
// nothing.
bool IsInsideRing(const PolygonRing& ring, const Eigen::Vector2d& point);

// Inside an odd number of the rings: outlines, holes and several polygons need no order.
bool IsInsideRings(const std::vector<PolygonRing>& rings, const Eigen::Vector2d& point);

// To the nearest place of the ring's edges, >= 0; infinite for an empty ring.
double DistanceToBorder(const PolygonRing& ring, const Eigen::Vector2d& point);

// Positive when the corners go counter-clockwise (the shoelace formula).
double SignedArea(const PolygonRing& ring);

}  // namespace colmap_ext
