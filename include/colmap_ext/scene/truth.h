// What a simulated scene knows about itself.
#pragma once

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

struct GroundTruth {
  TriangleMesh model;  // the object of interest, without ground; world (ENU)
  GeoPosition origin;  // of the ENU frame
};

}  // namespace colmap_ext
