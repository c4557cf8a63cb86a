// The fused oriented point set that the surface stage takes.
#pragma once

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

// Points on a regular pixel grid of every view (and one at the centroid of facets that the grid
// misses), on supported facets with enough confidence. Normals face the camera; colours come from
// the photo, or from the facet when the photo has no pixels. Order: by view, then by row. `views`
// has one entry a photo, in order.
OrientedPoints SamplePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const PointSamplerOptions& options);

}  // namespace colmap_ext
