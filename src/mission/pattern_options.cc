#include <cmath>

#include "colmap_ext/mission/flight_patterns.h"
#include "mission/pattern_names.h"

namespace colmap_ext {

std::string FlightPatternOptions::Check() const {
  if (!FindPattern(name)) {
    return "Pattern.name must be grid-downward, grid-multi-angle, 2-circles, rectangle-sparse, "
           "rectangle-dense or initial-rectangle";
  }
  if (num_views != 0 && (num_views < 4 || num_views > 10000)) {
    return "Pattern.num_views must be 0 or in 4 … 10000";
  }
  if (!(distance_m > 0) || !std::isfinite(distance_m)) return "Pattern.distance_m must be > 0";
  const auto is_overlap = [](double value) { return value >= 0 && value <= 0.95; };
  if (!is_overlap(forward_overlap)) return "Pattern.forward_overlap must be in 0 … 0.95";
  if (!is_overlap(side_overlap)) return "Pattern.side_overlap must be in 0 … 0.95";
  if (pitch_deg != 999 && !(pitch_deg >= -90 && pitch_deg < 90)) {
    return "Pattern.pitch_deg must be in [-90, 90), or 999 for the pattern's own";
  }
  if (num_angles < 2 || num_angles > 36) return "Pattern.num_angles must be in 2 … 36";
  if (num_levels < 0 || num_levels > 10) return "Pattern.num_levels must be in 0 … 10";
  if (!(height_above_top_m >= 0) || !std::isfinite(height_above_top_m)) {
    return "Pattern.height_above_top_m must be >= 0";
  }
  if (image_width_px < 1 || image_height_px < 1) return "Pattern.image sizes must be > 0";
  if (!(horizontal_fov_deg > 0 && horizontal_fov_deg <= 170)) {
    return "Pattern.horizontal_fov_deg must be in (0, 170]";
  }
  return "";
}

void BindOptions(OptionSet& set, FlightPatternOptions* options) {
  const std::string s = "Pattern";
  set.Add(s, "name", &options->name,
          "grid-downward, grid-multi-angle, 2-circles, rectangle-sparse, rectangle-dense or "
          "initial-rectangle");
  set.Add(s, "num_views", &options->num_views, "photos; 0: as many as the overlaps ask for");
  set.Add(s, "distance_m", &options->distance_m,
          "height above the top (grids) or distance from the sides (metres, > 0)");
  set.Add(s, "forward_overlap", &options->forward_overlap,
          "part that the next photo along the flight shows too (0 … 0.95)");
  set.Add(s, "side_overlap", &options->side_overlap,
          "part that the next line or level shows too (0 … 0.95)");
  set.Add(s, "pitch_deg", &options->pitch_deg,
          "camera pitch, positive up (degrees); 999: the pattern's own");
  set.Add(s, "num_angles", &options->num_angles,
          "directions at each place of grid-multi-angle (2 … 36)");
  set.Add(s, "num_levels", &options->num_levels,
          "circles or levels (1 … 10); 0: the pattern's own");
  set.Add(s, "height_above_top_m", &options->height_above_top_m,
          "least height of circles and rectangles above the top (metres, >= 0)");
  set.Add(s, "image_width_px", &options->image_width_px, "width of a photo (px)");
  set.Add(s, "image_height_px", &options->image_height_px, "height of a photo (px)");
  set.Add(s, "horizontal_fov_deg", &options->horizontal_fov_deg,
          "horizontal angle of view (degrees, 0 … 170)");
}

}  // namespace colmap_ext
