// Parts of buildings that several scenes share, built with real relief.
#pragma once

#include <vector>

#include "sim/scene_builder.h"

namespace colmap_ext {

// --- walls with openings ---
enum class OpeningStyle { kArched, kPointed, kRectangular };

struct Opening {
  double center_u = 0;  // m along the wall
  double sill_v = 0;    // m
  double width = 1;     // m
  double height = 2;    // m, arch included
  OpeningStyle style = OpeningStyle::kArched;
  double depth = 0.3;      // m, from the wall's plane to the pane
  double surround = 0.16;  // m, width of the dressed stone around it; 0: none
  int pane_material = -1;
  int bar_material = -1;  // mullions and louvres; -1: none
  bool louvres = false;   // slanted boards instead of a mullion
};
// Outline, counter-clockwise, grown by `grow` on all sides.
Polygon2d OpeningOutline(const Opening& opening, double grow);

struct WallMaterials {
  int wall = 0;
  int trim = 0;  // surrounds and reveals
};
// The polygon as a wall with recessed openings, surrounds that stand 5 cm proud, and sills. Its
// first edge is the wall's foot at v = 0; an opening with sill 0 is a door (at most one).
void AddWall(const WallMaterials& materials, const PlaneFrame& frame, const Polygon2d& outline,
             const std::vector<Opening>& openings, SceneBuilder* builder);

// --- roofs ---
// A roof slope in courses of overlapping tiles. The frame's origin is the middle of the eave, u
// along the eave, v up the slope. Half width goes linearly from `eave_half` at v = 0 to
// `ridge_half` at v = `length`.
struct TileSlope {
  PlaneFrame frame;
  double eave_half = 1, ridge_half = 1, length = 1;  // m
  double course = 0.32;                              // m
  double lift = 0.045;                               // m, of a course's lower edge
};
void AddTileSlope(int material, const TileSlope& slope, SceneBuilder* builder);

// Gabled building: local x from 0 to `length`, y centred.
struct GabledBuilding {
  double length = 10, width = 8, wall_height = 6, pitch_rad = 0.8;
  double eaves = 0.6;                          // m, overhang on the long sides
  double verge_low = 0.25, verge_high = 0.25;  // m, overhang at the gables x = 0 and x = length
  double thickness = 0.18;                     // m, of the roof
  std::vector<Opening> south, north;           // u from x = 0 (south) and from x = length (north)
  std::vector<Opening> gable_high;             // wall at x = length, u = y
  bool low_gable_wall = true;
  double RidgeHeight() const;  // underside of the roof
};
struct BuildingMaterials {
  WallMaterials walls;
  int tiles = 0;
  int wood = 0;
};
void AddGabledBuilding(const GabledBuilding& building, const BuildingMaterials& materials,
                       SceneBuilder* builder);

// Stepped buttress against a wall: `frame` has its origin at the foot in the middle, u along the
// wall, v up, the outside towards the viewer.
void AddButtress(const WallMaterials& materials, const PlaneFrame& frame, double width,
                 double height, double depth, SceneBuilder* builder);

// Flat ground in rings of falling resolution around the origin, 400 m wide so that no photo shows
// its end; paths and paving lie in the inner 80 m.
struct GroundMasks;
void AddOutdoorGround(std::uint32_t seed, const GroundMasks& masks, SceneBuilder* builder);

}  // namespace colmap_ext
