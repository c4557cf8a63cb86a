#include <cmath>

#include "colmap_ext/path/path_planner.h"

namespace colmap_ext {

std::string PathOptions::Check() const {
  if (!(safe_distance_m > 0 && safe_distance_m <= 1000)) {
    return "Path.safe_distance_m must be in (0, 1000]";
  }
  if (!(cell_size_m > 0 && cell_size_m <= 1000)) return "Path.cell_size_m must be in (0, 1000]";
  if (!(detour_margin_m >= 0 && detour_margin_m <= 10000)) {
    return "Path.detour_margin_m must be in 0 … 10000";
  }
  if (!std::isfinite(max_altitude_m)) return "Path.max_altitude_m must be finite (0: no ceiling)";
  if (unknown != "occupied" && unknown != "free") return "Path.unknown must be occupied or free";
  if (!(flown_margin_m >= 0 && flown_margin_m <= 1000)) {
    return "Path.flown_margin_m must be in 0 … 1000";
  }
  if (!(start_tolerance_m >= 0 && start_tolerance_m <= 1000)) {
    return "Path.start_tolerance_m must be in 0 … 1000";
  }
  if (!(proof_tolerance_m >= 0.002 && proof_tolerance_m <= 1)) {
    return "Path.proof_tolerance_m must be in 0.002 … 1";
  }
  if (!(speed_m_s > 0 && speed_m_s <= 30)) return "Path.speed_m_s must be in (0, 30]";
  if (!(yaw_rate_deg_s > 0 && yaw_rate_deg_s <= 360)) {
    return "Path.yaw_rate_deg_s must be in (0, 360]";
  }
  if (!(hover_s >= 0 && hover_s <= 600)) return "Path.hover_s must be in 0 … 600";
  return "";
}

void BindOptions(OptionSet& set, PathOptions* options) {
  const std::string s = "Path";
  set.Add(s, "safe_distance_m", &options->safe_distance_m,
          "least distance from the surface (metres, 0 … 1000)");
  set.Add(s, "cell_size_m", &options->cell_size_m, "cells of the search grid (metres, > 0)");
  set.Add(s, "detour_margin_m", &options->detour_margin_m,
          "how far the grid goes beyond the views (metres, >= 0)");
  set.Add(s, "max_altitude_m", &options->max_altitude_m,
          "highest z of the world to fly at (metres); 0: no ceiling");
  set.Add(s, "unknown", &options->unknown, "what unknown space counts as: occupied or free");
  set.Add(s, "flown_margin_m", &options->flown_margin_m,
          "known free around the hull of the flown path (metres, >= 0)");
  set.Add(s, "start_tolerance_m", &options->start_tolerance_m,
          "how much nearer than the safe distance the start may be (metres, >= 0)");
  set.Add(s, "proof_tolerance_m", &options->proof_tolerance_m,
          "margin of the clearance proof (metres, 0.002 … 1)");
  set.Add(s, "speed_m_s", &options->speed_m_s, "flying speed (m/s, 0 … 30)");
  set.Add(s, "yaw_rate_deg_s", &options->yaw_rate_deg_s, "turning rate (degrees/s, 0 … 360)");
  set.Add(s, "hover_s", &options->hover_s, "time for a photo (seconds, 0 … 600)");
}

}  // namespace colmap_ext
