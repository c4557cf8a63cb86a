// Iso-points: the samples of the surface that coverage evaluation classifies.
#pragma once

#include <cstdint>
#include <vector>

#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/surface.h"

namespace colmap_ext {

struct IsoPoints {
  std::vector<IsoPoint> points;  // position, normal and sample_spacing_m are set
  double spacing_m = 0;          // no two points are nearer
  double disk_area_m2 = 0;       // surface area over number of points: A_p of the paper
};

// Poisson-disk samples of the surface. spacing_m = 0: chosen so that about 7500 points come out.
// The signal is interpolated on the face; a surface without signal (empty sample_spacing_m: a mesh
// of unknown origin) gives its diagonal, which means "no support known". Same input, same points.
// Throws Error for a surface without area, or with a signal of the wrong size.
IsoPoints SampleIsoPoints(const Surface& surface, double spacing_m, std::uint64_t seed);

}  // namespace colmap_ext
