// How much of the sky a vertex sees, so that recesses and eaves are darker than open walls.
#pragma once

#include <vector>

#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

struct AmbientLight {
  float sky = 1;     // cosine-weighted part of the half sphere that is open
  float bounce = 0;  // part that is closed by surfaces, nearer ones counting less (they are dark)
};

// One a vertex, over `rays` fixed directions a vertex. With rays == 0 the half sphere around the
// normal is open above the horizon and closed below it.
std::vector<AmbientLight> ComputeAmbientLight(const TexturedScene& scene, int rays);

}  // namespace colmap_ext
