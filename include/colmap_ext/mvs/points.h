// The fused oriented point set that the surface stage takes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/scene/oriented_points.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct PointSamplerOptions {
  int step_px = 6;              // a point every so many pixels of a photo; [1, 64]
  double min_confidence = 0.5;  // only facets with a higher Γ give points; [0, 1]
  // A point is dropped when more neighbours look through it at something confident that is further
  // away by this share of the depth than confirm it within that share; (0, 1].
  double free_space_tolerance = 0.02;

  std::string Check() const;
};

// Section "PointSampler".
void BindOptions(OptionSet& set, PointSamplerOptions* options);

// Where a view gives a point.
struct PointSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  int triangle = 0;
  std::array<std::uint8_t, 3> color{};  // RGB
};

// Points on a regular pixel grid of every view (and one at the centroid of facets that the grid
// misses), on supported facets with enough confidence. Normals face the camera; colours come from
// the photo, or from the facet when the photo has no pixels. Order: by view, then by row. `views`
// and `neighbors` (best first) have one entry a photo, in order.
OrientedPoints SamplePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const std::vector<std::vector<int>>& neighbors,
                            const PointSamplerOptions& options);

struct StereoMemory;

// The same, for the views of an update (UpdateSuperpixelStereo, whose `memory` has every photo):
// those that kept their mesh give the points where they gave them before. `memory` is updated.
OrientedPoints UpdatePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const std::vector<std::vector<int>>& neighbors,
                            const PointSamplerOptions& options, StereoMemory* memory);

}  // namespace colmap_ext
