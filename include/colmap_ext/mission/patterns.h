// Flights that need no model: the first one around a building.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct InitialFlightOptions {
  // Photos, 4 … 10000. Paper, Sec. "Church": 64.
  int num_views = 64;
  // Horizontal distance of the rectangle from the sides of the box, metres, > 0.
  double offset_m = 10;
  // Height of the flight (z of the world), metres; 0: chosen as InitialFlightHeight says.
  double height_m = 0;
  // The chosen height is at least this far above the top of the box, metres, >= 0. The paper's
  // vehicle always flies above what is not known yet; its gate is 15 m high and the flight 18 m.
  double height_above_top_m = 2;
  // Camera pitch, degrees, (-90, 90), positive up. Paper: 30 degrees downward.
  double pitch_deg = -30;
  // Largest change of heading between neighbouring photos at the corners, degrees, (0, 90]. SfM
  // needs their overlap. Kept as long as the sides are long enough to turn on.
  double max_turn_deg = 15;

  std::string Check() const;
};

// Section "InitialFlight".
void BindOptions(OptionSet& set, InitialFlightOptions* options);

// Height (z of the world, metres) at which a camera with this pitch, `offset_m` outside the middle
// of a side, looks at the centre of the box:
//   z = z_centre - tan(pitch) (offset + half extent),
// with the mean of the half extents in x and y, so that one height serves all four sides; but never
// lower than the top of the box + height_above_top_m. `options.height_m` wins when it is not 0.
double InitialFlightHeight(const RegionOfInterest& region, const InitialFlightOptions& options);

// Views spread evenly along the rectangle around `region`, counter-clockwise seen from above, the
// first one at the south-western corner. On the sides they look inward at right angles; around the
// corners the heading turns evenly (at a corner: along the diagonal). ids 0 … num_views - 1.
// Throws UsageError for bad options, Error for an empty or non-finite box.
std::vector<PlannedView> InitialRectangle(const RegionOfInterest& region,
                                          const InitialFlightOptions& options);

// The views flown in their order, straight from one to the next. Nothing is proved about it
// (min_clearance_m = 0), for there is no model yet: the pilot vouches for the first flight.
FlightPath PathInOrder(const std::vector<PlannedView>& views, double speed_m_s, double hover_s);

}  // namespace colmap_ext
