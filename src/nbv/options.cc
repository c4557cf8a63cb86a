#include <cmath>

#include "colmap_ext/nbv/plane_sweep.h"

namespace colmap_ext {
namespace {

std::string CheckAngles(const NextBestViewOptions& o) {
  if (o.num_pitches < 1 || o.num_pitches > 180)
    return "NextBestView.num_pitches must be in 1 … 180";
  if (!(o.min_pitch_deg > -90 && o.max_pitch_deg < 90 && o.min_pitch_deg <= o.max_pitch_deg)) {
    return "NextBestView.min_pitch_deg and max_pitch_deg must be in (-90, 90), the first the "
           "smaller";
  }
  if (o.num_yaws < 1 || o.num_yaws > 360) return "NextBestView.num_yaws must be in 1 … 360";
  if (!(o.max_angle_to_existing_deg > 0 && o.max_angle_to_existing_deg <= 180)) {
    return "NextBestView.max_angle_to_existing_deg must be in (0, 180]";
  }
  if (!(o.min_pair_angle_deg >= 0 && o.max_pair_angle_deg <= 180 &&
        o.min_pair_angle_deg < o.max_pair_angle_deg)) {
    return "NextBestView.min_pair_angle_deg and max_pair_angle_deg must be in 0 … 180, the first "
           "the smaller";
  }
  return "";
}

std::string CheckLengths(const NextBestViewOptions& o) {
  if (!(o.nms_radius_m >= 0)) return "NextBestView.nms_radius_m must be >= 0 (metres)";
  if (!(o.max_distance_to_existing_m > 0 && o.max_distance_to_existing_m <= 1000)) {
    return "NextBestView.max_distance_to_existing_m must be in (0, 1000]";
  }
  if (!(o.safe_distance_m > 0 && o.safe_distance_m <= 1000)) {
    return "NextBestView.safe_distance_m must be in (0, 1000]";
  }
  if (!(o.grid_spacing_m >= 0.01 && o.grid_spacing_m <= 1000)) {
    return "NextBestView.grid_spacing_m must be in 0.01 … 1000";
  }
  if (!(o.plane_step_m >= 0.01 && o.plane_step_m <= 1000)) {
    return "NextBestView.plane_step_m must be in 0.01 … 1000";
  }
  if (!std::isfinite(o.min_altitude_m) || !std::isfinite(o.max_altitude_m)) {
    return "NextBestView.min_altitude_m and max_altitude_m must be finite (metres)";
  }
  if (!(o.max_range_m > 0 && o.max_range_m <= 10000)) {
    return "NextBestView.max_range_m must be in (0, 10000]";
  }
  return "";
}

}  // namespace

std::string NextBestViewOptions::Check() const {
  if (num_views < 1 || num_views > 1000) return "NextBestView.num_views must be in 1 … 1000";
  if (!(min_relative_score >= 0 && min_relative_score <= 1)) {
    return "NextBestView.min_relative_score must be in 0 … 1";
  }
  if (!(seen_weight >= 0 && seen_weight <= 1)) return "NextBestView.seen_weight must be in 0 … 1";
  for (const std::string& complaint :
       {CheckAngles(*this), CheckLengths(*this), visibility.Check()}) {
    if (!complaint.empty()) return complaint;
  }
  return "";
}

void BindOptions(OptionSet& set, NextBestViewOptions* o) {
  const std::string s = "NextBestView";
  set.Add(s, "num_pitches", &o->num_pitches, "camera pitches that are tried (1 … 180)");
  set.Add(s, "min_pitch_deg", &o->min_pitch_deg, "lowest pitch (degrees, -90 … 90)");
  set.Add(s, "max_pitch_deg", &o->max_pitch_deg, "highest pitch (degrees, -90 … 90)");
  set.Add(s, "num_yaws", &o->num_yaws, "headings that are tried (1 … 360)");
  set.Add(s, "num_views", &o->num_views, "views of one plan (1 … 1000)");
  set.Add(s, "nms_radius_m", &o->nms_radius_m, "least distance between chosen views (metres)");
  set.Add(s, "max_angle_to_existing_deg", &o->max_angle_to_existing_deg,
          "nearness to an existing view in yaw and in pitch (degrees, 0 … 180)");
  set.Add(s, "max_distance_to_existing_m", &o->max_distance_to_existing_m,
          "nearness to an existing view in position (metres; indoors 0.5)");
  set.Add(s, "safe_distance_m", &o->safe_distance_m, "least distance from the surface (metres)");
  set.Add(s, "grid_spacing_m", &o->grid_spacing_m, "spacing of positions on a plane (metres)");
  set.Add(s, "plane_step_m", &o->plane_step_m, "spacing of planes going down (metres)");
  set.Add(s, "min_relative_score", &o->min_relative_score,
          "accept a plane at this part of the best plane's score (0 … 1)");
  set.Add(s, "min_altitude_m", &o->min_altitude_m,
          "least height of views above the lowest iso-point (metres)");
  set.Add(s, "max_altitude_m", &o->max_altitude_m,
          "highest z of the world for views (metres); 0: no limit");
  set.Add(s, "max_range_m", &o->max_range_m, "points further away do not count (metres)");
  set.Add(s, "stereo_aware", &o->stereo_aware,
          "count points only for views that help stereo (0, 1)");
  set.Add(s, "min_pair_angle_deg", &o->min_pair_angle_deg, "least angle of a good pair (degrees)");
  set.Add(s, "max_pair_angle_deg", &o->max_pair_angle_deg,
          "largest angle of a good pair (degrees)");
  set.Add(s, "seen_weight", &o->seen_weight,
          "what points count that chosen views cover already (0 … 1)");
  set.Add(s, "chain_views", &o->chain_views, "views may be near to views of the same plan (0, 1)");
  set.Add(s, "several_planes", &o->several_planes, "fill a plan from the next best planes (0, 1)");
  set.Add(s, "bridge", &o->bridge, "lead on to views that are out of reach (0, 1)");
}

}  // namespace colmap_ext
