// The points whose Voronoi cells are the superpixels.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/mvs/superpixels.h"

namespace colmap_ext {

struct SuperpixelSites {
  std::vector<Eigen::Vector2d> points_px;  // inside the image, no two alike
  std::size_t num_anchors = 0;             // the first ones, in pairs, follow the segments
  // No point of the image is further than this from a site.
  double cover_radius_px = 0;
};

// Pairs of anchors on both sides of each segment (longest first; a pair that would bend the
// boundary of an earlier segment is left out), then a Poisson-disk process where no anchor is near.
SuperpixelSites PlaceSites(const std::vector<LineSegment>& segments, int width, int height,
                           const SuperpixelOptions& options);

}  // namespace colmap_ext
