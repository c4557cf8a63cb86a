// The classic flight plans of aerial mapping, which the paper compares with (Sec.
// "Manually-designed Flight Plans"; it shows them in a picture only, so the figures here are ours).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/mission/patterns.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

struct FlightPatternOptions {
  // "grid-downward", "grid-multi-angle", "2-circles", "rectangle-sparse", "rectangle-dense" or
  // "initial-rectangle"; any case, '_' as good as '-'.
  std::string name = "initial-rectangle";
  // Photos; 0: as many as the overlaps ask for. Paper: 143, 858, 105, 130, 390.
  int num_views = 0;
  // Distance from what is photographed, metres, > 0: a grid flies so high above the top of the
  // site, circles and rectangles so far outside of its sides.
  double distance_m = 10;
  // Part of a photo that the next one along the flight, and that of the next line, level or circle
  // shows too, at that distance, [0, 0.95]. Counts win over overlaps.
  double forward_overlap = 0.8;
  double side_overlap = 0.6;
  // Camera pitch, degrees, [-90, 90), positive up; of a pattern with several the first one. 999:
  // the pattern's own.
  double pitch_deg = 999;
  // Directions at each place of grid-multi-angle, the first one down, 2 … 36. Paper: 858 = 6 * 143.
  int num_angles = 6;
  // Circles of 2-circles, or levels of rectangle-dense, 1 … 10; 0: the pattern's own (2; 3).
  int num_levels = 0;
  // Circles and rectangles are at least so far above the top of the site, metres, >= 0: what is not
  // known yet is flown over.
  double height_above_top_m = 2;
  // The camera: pixels, and the horizontal angle of view in degrees, (0, 170].
  int image_width_px = 640;
  int image_height_px = 368;
  double horizontal_fov_deg = 80;

  std::string Check() const;
};

// Section "Pattern".
void BindOptions(OptionSet& set, FlightPatternOptions* options);

// Where the pattern is flown: an upright box, turned about the vertical.
struct PatternSite {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();       // world (ENU), metres
  Eigen::Vector2d half_extent = Eigen::Vector2d::Zero();  // along its own axes, > 0
  double turn_rad = 0;  // of its x axis from east, counter-clockwise
  double min_z_m = 0, max_z_m = 0;
  // The outline of a polygon, world; empty: the box. A grid leaves out what is further outside than
  // half its spacing.
  std::vector<Eigen::Vector2d> outline;
};

PatternSite SiteOfBox(const BoundingBox& box);
// The smallest box around the outline of the zone, whichever way it is turned. The heights are the
// zone's; those that it does not limit are `min_z_m`, `max_z_m`. Throws Error without an outline.
PatternSite SiteOfZone(const FlightZone& zone, double min_z_m, double max_z_m);

// The views in the order of flight, ids from 0. Throws UsageError for bad options, Error for an
// empty or non-finite site, or when the overlaps ask for more than 10000 photos.
// - grid-downward: lines back and forth along the longer side, camera down (-90°).
// - grid-multi-angle: the same places; at each one photo down, the others obliquely (-45°), evenly
//   around.
// - 2-circles: around the middle, looking at it, with the pitches -30° and -50°: the steeper the
//   higher. Photos by length of the circles (all the same), the first circle takes one that is left
//   over.
// - rectangle-sparse: once around, as the first flight of a session, pitch -30°.
// - rectangle-dense: as that on three levels, pitches -15°, -30°, -45°, the steeper the higher.
// - initial-rectangle: rectangle-sparse with 64 photos (paper).
std::vector<PlannedView> MakeFlightPattern(const PatternSite& site,
                                           const FlightPatternOptions& options);

}  // namespace colmap_ext
