// The Voronoi cells of sites in an image, as triangles.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// Cells of `sites_px` (at least one, all strictly inside [0, width] x [0, height], no two alike),
// clipped to the image. Vertices joined by an edge shorter than merge_px become one (cells that
// shrink to an edge vanish), each cell is split into the triangles whose smallest height is
// largest, and no triangle is smaller than 0.05 px². Fills everything but mean_bgr.
// `cover_radius_px` bounds the distance of any image point from its site.
ImageMesh BuildVoronoiMesh(const std::vector<Eigen::Vector2d>& sites_px, int width, int height,
                           double cover_radius_px, double merge_px);

// Fills mesh->neighbors from mesh->triangles.
void ConnectTriangles(ImageMesh* mesh);

}  // namespace colmap_ext
