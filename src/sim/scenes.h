// The three scenes made by procedure; see MakeScene.
#pragma once

#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

TexturedScene MakeChurch(std::uint64_t seed, double texel_scale);
TexturedScene MakeGate(std::uint64_t seed, double texel_scale);
TexturedScene MakeBoxes(std::uint64_t seed, double texel_scale);

}  // namespace colmap_ext
