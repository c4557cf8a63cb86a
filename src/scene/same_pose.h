// When two poses of a COLMAP model are taken as one.
#pragma once

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// Photos of a frame may differ from their places in the rig by rounding only. Equal to 1e-6:
// radians, and metres per metre from the origin (what a text file keeps).
inline bool AreSamePoses(const Rigid3d& a, const Rigid3d& b) {
  constexpr double kTolerance = 1e-6;
  return a.rotation.angularDistance(b.rotation) < kTolerance &&
         (a.translation - b.translation).norm() < kTolerance * (1 + a.translation.norm());
}

}  // namespace colmap_ext
