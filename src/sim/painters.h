// Procedural materials. All lengths in metres. Each has detail from some centimetres to metres, so
// that feature detectors find enough at every distance, and no two places look alike.
#pragma once

#include <functional>

#include "sim/scene_builder.h"

namespace colmap_ext {

using Rgb = Eigen::Vector3f;

inline Rgb Blend(const Rgb& a, const Rgb& b, float t) { return a + (b - a) * t; }

// --- building stone, tile, wood, glass (painters.cc) ---
// Coursed rubble walls: blocks of random length and colour, mortar, rain streaks, moss near the
// ground.
Painter RubbleStone(std::uint32_t seed);
// Smooth dressed stone of large blocks: plinths, surrounds, caps.
Painter DressedStone(std::uint32_t seed, const Rgb& tone);
// Plain tiles in courses of `course_m` from the chart's lower edge; lichen, broken and darker
// tiles.
Painter RoofTiles(std::uint32_t seed, float course_m, const Rgb& dark, const Rgb& light);
// Planks along the chart's v axis (or u axis).
Painter Planks(std::uint32_t seed, float width_m, const Rgb& tone, bool along_u);
// Diamond panes in lead, each of another colour.
Painter LeadedGlass(std::uint32_t seed);
Painter Iron(std::uint32_t seed);

// --- Asian gate (painters_gate.cc) ---
Painter GlazedTubes(std::uint32_t seed, float pitch_m);  // tubes along v
Painter LacqueredWood(std::uint32_t seed, const Rgb& tone);
Painter PaintedBeam(std::uint32_t seed);  // ornament in blue, green and gold
Painter StuddedDoor(std::uint32_t seed);

// --- indoors (painters_boxes.cc) ---
Painter Cardboard(std::uint32_t seed);
Painter Parquet(std::uint32_t seed);
Painter PosteredWall(std::uint32_t seed);

// --- outdoor ground (painters_ground.cc) ---
struct GroundMasks {
  // 0 … 1 at a place (x, y): how much of it is gravel, or flagstones; the rest is grass.
  std::function<float(const Eigen::Vector2f&)> gravel;
  std::function<float(const Eigen::Vector2f&)> paving;
};
Painter Ground(std::uint32_t seed, const GroundMasks& masks);
// Bare soil and grass without paths.
Painter Meadow(std::uint32_t seed);

// 1 on dots of letters that stand in lines of `height_m`; a random script that never repeats.
float PseudoText(const Eigen::Vector2f& uv, float height_m, std::uint32_t seed);

}  // namespace colmap_ext
