// Models without metric positions: a frame in which coverage still means something.
#pragma once

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// The distance at which a photo of `model` just has the wanted ground sampling distance with a
// margin of a third: a scale for models that have none, at which typical surfaces pass the
// resolution test.
double TypicalViewingDistance(const CoverageOptions& options, const Reconstruction& model);

// Moves `model` so that the mean of the cameras' upward axes is z, and scales it so that the median
// distance from a camera to the points that it sees is `distance_m`.
void NormalizeArbitraryFrame(double distance_m, Reconstruction* model);

}  // namespace colmap_ext
