#include <cmath>
#include <cstdio>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Complaints about the estimate of time and battery.
std::string CheckTimes(const PathOptions& o) {
  const auto is_speed = [](double value) { return value > 0 && value <= 30; };
  if (!is_speed(o.speed_m_s)) return "Path.speed_m_s must be in (0, 30]";
  if (!is_speed(o.climb_speed_m_s)) return "Path.climb_speed_m_s must be in (0, 30]";
  if (!is_speed(o.descent_speed_m_s)) return "Path.descent_speed_m_s must be in (0, 30]";
  if (!is_speed(o.acceleration_m_s2)) return "Path.acceleration_m_s2 must be in (0, 30]";
  if (!(o.yaw_rate_deg_s > 0 && o.yaw_rate_deg_s <= 360)) {
    return "Path.yaw_rate_deg_s must be in (0, 360]";
  }
  if (!(o.hover_s >= 0 && o.hover_s <= 600)) return "Path.hover_s must be in 0 … 600";
  if (!(o.takeoff_landing_s >= 0 && o.takeoff_landing_s <= 3600)) {
    return "Path.takeoff_landing_s must be in 0 … 3600";
  }
  if (!(o.battery_s >= 0 && o.battery_s <= 1e6)) return "Path.battery_s must be in 0 … 1000000";
  if (!(o.battery_reserve >= 0 && o.battery_reserve < 1)) {
    return "Path.battery_reserve must be in [0, 1)";
  }
  if (o.battery_s > 0 && !(o.battery_s * (1 - o.battery_reserve) > o.takeoff_landing_s)) {
    return "Path.battery_s less the reserve leaves nothing to fly after Path.takeoff_landing_s";
  }
  return "";
}

}  // namespace

Eigen::Vector3d ParsePlace(const std::string& text) {
  Eigen::Vector3d place;
  char rest = 0;
  const int count =
      std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &place.x(), &place.y(), &place.z(), &rest);
  if (count != 3 || !place.allFinite()) {
    throw UsageError("\"" + text + "\" must be x,y,z in metres");
  }
  return place;
}

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
  if (!(position_error_m >= 0 && position_error_m <= 100)) {
    return "Path.position_error_m must be in 0 … 100";
  }
  if (!(confident_spacing_m >= 0)) return "Path.confident_spacing_m must be >= 0";
  try {
    FreeSpaceOptions unused;
    SetFreeVolume(free_volume, &unused);
  } catch (const UsageError& error) {
    return error.what();
  }
  try {
    if (!home.empty()) ParsePlace(home);
  } catch (const UsageError& error) {
    return std::string("Path.home ") + error.what();
  }
  return CheckTimes(*this);
}

void BindOptions(OptionSet& set, PathOptions* options) {
  const std::string s = "Path";
  set.Add(s, "safe_distance_m", &options->safe_distance_m,
          "least distance from the surface (metres, 0 … 1000)");
  set.Add(s, "position_error_m", &options->position_error_m,
          "how far the vehicle may be off its line, added to the safe distance (metres, >= 0)");
  set.Add(s, "cell_size_m", &options->cell_size_m, "cells of the search grid (metres, > 0)");
  set.Add(s, "detour_margin_m", &options->detour_margin_m,
          "how far the grid goes beyond the views (metres, >= 0)");
  set.Add(s, "max_altitude_m", &options->max_altitude_m,
          "highest z of the world to fly at (metres); 0: no ceiling");
  set.Add(s, "unknown", &options->unknown, "what unknown space counts as: occupied or free");
  set.Add(s, "limits_path", &options->limits_path,
          "GeoJSON of geofence and no-fly zones, with altitude limits");
  set.Add(s, "flown_margin_m", &options->flown_margin_m,
          "known free around the hull of the vouched photos (metres, >= 0)");
  set.Add(s, "vouched_image_list_path", &options->vouched_image_list_path,
          "names of the photos, one a line, of flights that a person planned and vouches for; "
          "empty: see vouch_planned_flights");
  set.Add(
      s, "vouch_planned_flights", &options->vouch_planned_flights,
      "a session's planned flights vouch for what is around them, too (0, 1); 0: only its first "
      "iteration's photos do");
  set.Add(s, "free_volume", &options->free_volume,
          "what the pilot vouches for, by ';': flown (around the vouched photos), above_top, boxes "
          "x,y,z,x,y,z, GeoJSON files; or none");
  set.Add(s, "confident_spacing_m", &options->confident_spacing_m,
          "rays free what is before surface whose points are this dense (metres); 0: all of it");
  set.Add(s, "start_tolerance_m", &options->start_tolerance_m,
          "how much nearer than the safe distance the start may be (metres, >= 0)");
  set.Add(s, "proof_tolerance_m", &options->proof_tolerance_m,
          "margin of the clearance proof (metres, 0.002 … 1)");
  set.Add(s, "speed_m_s", &options->speed_m_s, "flying speed (m/s, 0 … 30)");
  set.Add(s, "climb_speed_m_s", &options->climb_speed_m_s, "climbing speed (m/s, 0 … 30)");
  set.Add(s, "descent_speed_m_s", &options->descent_speed_m_s, "descending speed (m/s, 0 … 30)");
  set.Add(s, "acceleration_m_s2", &options->acceleration_m_s2, "acceleration (m/s², 0 … 30)");
  set.Add(s, "yaw_rate_deg_s", &options->yaw_rate_deg_s, "turning rate (degrees/s, 0 … 360)");
  set.Add(s, "hover_s", &options->hover_s, "time for a photo (seconds, 0 … 600)");
  set.Add(s, "takeoff_landing_s", &options->takeoff_landing_s,
          "take-off and landing of a flight (seconds, 0 … 3600)");
  set.Add(s, "battery_s", &options->battery_s,
          "flying time of a full battery (seconds); 0: no limit");
  set.Add(s, "battery_reserve", &options->battery_reserve,
          "part of the battery that is left after landing (0 … 1)");
  set.Add(s, "home", &options->home,
          "x,y,z where batteries are changed (world, metres); empty: where the path starts");
  set.Add(s, "return_home", &options->return_home, "end the path at home");
}

}  // namespace colmap_ext
