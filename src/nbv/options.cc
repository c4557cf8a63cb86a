#include <algorithm>
#include <array>
#include <cmath>

#include "colmap_ext/nbv/next_best_views.h"

namespace colmap_ext {
namespace {

std::string CheckAngles(const NextBestViewOptions& o) {
  if (!(o.min_gimbal_pitch_deg >= -90 && o.max_gimbal_pitch_deg <= 90 &&
        o.min_gimbal_pitch_deg <= o.max_gimbal_pitch_deg)) {
    return "NextBestView.min_gimbal_pitch_deg and max_gimbal_pitch_deg must be in -90 … 90, the "
           "first the smaller";
  }
  if (!(o.sun_weight >= 0 && o.sun_weight <= 1)) return "NextBestView.sun_weight must be in 0 … 1";
  if (!(std::abs(o.sun_azimuth_deg) <= 360 && std::abs(o.sun_elevation_deg) <= 90)) {
    return "NextBestView.sun_azimuth_deg must be in -360 … 360, sun_elevation_deg in -90 … 90";
  }
  if (!(o.max_feature_angle_deg > 0 && o.max_feature_angle_deg <= 90)) {
    return "NextBestView.max_feature_angle_deg must be in (0, 90]";
  }
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
  if (!(o.max_distance_m == 0 ||
        (o.max_distance_m > o.safe_distance_m && o.max_distance_m <= 10000))) {
    return "NextBestView.max_distance_m must be 0 (no limit) or above safe_distance_m";
  }
  if (!(o.max_tour_length_m >= 0 && o.max_tour_duration_s >= 0)) {
    return "NextBestView.max_tour_length_m and max_tour_duration_s must be >= 0 (0: no limit)";
  }
  if (!(o.speed_m_s > 0 && o.yaw_rate_deg_s > 0 && o.hover_s >= 0)) {
    return "speed and yaw rate of the vehicle must be above 0, the time of a photo >= 0";
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

std::string CheckPool(const NextBestViewOptions& o) {
  if (o.num_positions < 10 || o.num_positions > 100000) {
    return "NextBestView.num_positions must be in 10 … 100000";
  }
  if (o.views_a_position < 1 || o.views_a_position > 32) {
    return "NextBestView.views_a_position must be in 1 … 32";
  }
  if (o.num_points < 100 || o.num_points > 1000000) {
    return "NextBestView.num_points must be in 100 … 1000000";
  }
  if (!(o.ratio_reserve >= 1 && o.ratio_reserve <= 10)) {
    return "NextBestView.ratio_reserve must be in 1 … 10";
  }
  if (!(o.min_relative_gain >= 0 && o.min_relative_gain <= 1)) {
    return "NextBestView.min_relative_gain must be in 0 … 1";
  }
  if (!(o.min_shared_features >= 0 && o.min_shared_features <= 100000)) {
    return "NextBestView.min_shared_features must be in 0 … 100000";
  }
  if (!(o.max_feature_scale > 1 && o.max_feature_scale <= 100)) {
    return "NextBestView.max_feature_scale must be above 1 and at most 100";
  }
  return "";
}

void BindShared(OptionSet& set, const std::string& s, NextBestViewOptions* o) {
  set.Add(s, "num_views", &o->num_views, "views of one plan (1 … 1000)");
  set.Add(s, "safe_distance_m", &o->safe_distance_m, "least distance from the surface (metres)");
  set.Add(s, "max_distance_m", &o->max_distance_m,
          "largest distance from the surface (metres); 0: no limit");
  set.Add(s, "min_altitude_m", &o->min_altitude_m,
          "least height of views above the lowest iso-point (metres)");
  set.Add(s, "max_altitude_m", &o->max_altitude_m,
          "highest z of the world for views (metres); 0: no limit");
  set.Add(s, "min_gimbal_pitch_deg", &o->min_gimbal_pitch_deg,
          "lowest pitch of the gimbal (degrees, -90 … 90)");
  set.Add(s, "max_gimbal_pitch_deg", &o->max_gimbal_pitch_deg,
          "highest pitch of the gimbal (degrees, -90 … 90)");
  set.Add(s, "max_range_m", &o->max_range_m, "points further away do not count (metres)");
  set.Add(s, "min_pair_angle_deg", &o->min_pair_angle_deg, "least angle of a good pair (degrees)");
  set.Add(s, "max_pair_angle_deg", &o->max_pair_angle_deg,
          "largest angle of a good pair (degrees)");
  set.Add(s, "sun_weight", &o->sun_weight,
          "what looking at the sun costs of a view's score (0 … 1; 0: nothing)");
  set.Add(s, "sun_azimuth_deg", &o->sun_azimuth_deg, "where the sun stands, from north (degrees)");
  set.Add(s, "sun_elevation_deg", &o->sun_elevation_deg,
          "how high the sun stands above the horizon (degrees)");
  set.Add(s, "min_shared_features", &o->min_shared_features,
          "features that a view must share with earlier ones, predicted; 0: not asked");
  set.Add(s, "max_feature_angle_deg", &o->max_feature_angle_deg,
          "features are matched within this angle between two views (degrees)");
  set.Add(s, "max_feature_scale", &o->max_feature_scale,
          "features are matched up to this ratio of distances (> 1)");
}

void BindPool(OptionSet& set, const std::string& s, NextBestViewOptions* o) {
  set.Add(s, "num_positions", &o->num_positions, "submodular: positions of the pool (10 … 100000)");
  set.Add(s, "views_a_position", &o->views_a_position,
          "submodular: directions kept at a position (1 … 32)");
  set.Add(s, "num_points", &o->num_points,
          "submodular: uncovered points are thinned to about so many");
  set.Add(s, "ratio_reserve", &o->ratio_reserve,
          "submodular: points are seen at this many times the least ratio (1 … 10)");
  set.Add(s, "max_tour_length_m", &o->max_tour_length_m,
          "submodular: budget of the tour (metres); 0: none");
  set.Add(s, "max_tour_duration_s", &o->max_tour_duration_s,
          "submodular: budget of the tour (seconds of battery); 0: none");
  set.Add(s, "return_to_start", &o->return_to_start,
          "submodular: the budgets include the way back (0, 1)");
  set.Add(s, "min_relative_gain", &o->min_relative_gain,
          "submodular: end where a view gains less than this part of the first (0 … 1)");
  set.Add(
      s, "objective", &o->objective,
      "submodular: stereo (pairs by the paper's rule) or predicted_error (how accurate they are)");
  set.Add(s, "seed", &o->seed, "random: seed of the choice");
}

}  // namespace

std::string NextBestViewOptions::Check() const {
  static constexpr std::array<const char*, 6> kStrategies = {
      "submodular", "plane_sweep", "random", "next_farthest_point", "hemisphere", "smith2018"};
  if (std::find(kStrategies.begin(), kStrategies.end(), strategy) == kStrategies.end()) {
    return "NextBestView.strategy must be submodular, plane_sweep, random, next_farthest_point, "
           "hemisphere or smith2018";
  }
  if (objective != "stereo" && objective != "predicted_error") {
    return "NextBestView.objective must be stereo or predicted_error";
  }
  if (paper_only && strategy != "plane_sweep") {
    return "NextBestView.paper_only goes with --NextBestView.strategy plane_sweep";
  }
  if (coarse_step < 1 || coarse_step > 8) return "NextBestView.coarse_step must be in 1 … 8";
  if (num_views < 1 || num_views > 1000) return "NextBestView.num_views must be in 1 … 1000";
  if (!(min_relative_score >= 0 && min_relative_score <= 1)) {
    return "NextBestView.min_relative_score must be in 0 … 1";
  }
  if (!(seen_weight >= 0 && seen_weight <= 1)) return "NextBestView.seen_weight must be in 0 … 1";
  for (const std::string& complaint :
       {CheckAngles(*this), CheckLengths(*this), CheckPool(*this), visibility.Check()}) {
    if (!complaint.empty()) return complaint;
  }
  return "";
}

void BindOptions(OptionSet& set, NextBestViewOptions* o) {
  const std::string s = "NextBestView";
  set.Add(s, "strategy", &o->strategy,
          "submodular or plane_sweep; to compare with: random, next_farthest_point, hemisphere, "
          "smith2018");
  BindShared(set, s, o);
  BindPool(set, s, o);
  set.Add(s, "paper_only", &o->paper_only,
          "plane_sweep: the paper's search and none of what was added to it (0, 1)");
  set.Add(s, "coarse_step", &o->coarse_step,
          "planes are compared at every so many-th position (1 … 8; 1: all)");
  set.Add(s, "num_pitches", &o->num_pitches, "camera pitches that are tried (1 … 180)");
  set.Add(s, "min_pitch_deg", &o->min_pitch_deg, "lowest pitch (degrees, -90 … 90)");
  set.Add(s, "max_pitch_deg", &o->max_pitch_deg, "highest pitch (degrees, -90 … 90)");
  set.Add(s, "num_yaws", &o->num_yaws, "headings that are tried (1 … 360)");
  set.Add(s, "nms_radius_m", &o->nms_radius_m, "least distance between chosen views (metres)");
  set.Add(s, "max_angle_to_existing_deg", &o->max_angle_to_existing_deg,
          "nearness to an existing view in yaw and in pitch (degrees, 0 … 180)");
  set.Add(s, "max_distance_to_existing_m", &o->max_distance_to_existing_m,
          "nearness to an existing view in position (metres; indoors 0.5)");
  set.Add(s, "grid_spacing_m", &o->grid_spacing_m, "spacing of positions on a plane (metres)");
  set.Add(s, "plane_step_m", &o->plane_step_m, "spacing of planes going down (metres)");
  set.Add(s, "min_relative_score", &o->min_relative_score,
          "accept a plane at this part of the best plane's score (0 … 1)");
  set.Add(s, "stereo_aware", &o->stereo_aware,
          "count points only for views that help stereo (0, 1)");
  set.Add(s, "seen_weight", &o->seen_weight,
          "what points count that chosen views cover already (0 … 1)");
  set.Add(s, "chain_views", &o->chain_views, "views may be near to views of the same plan (0, 1)");
  set.Add(s, "several_planes", &o->several_planes, "fill a plan from the next best planes (0, 1)");
  set.Add(s, "bridge", &o->bridge, "lead on to views that are out of reach (0, 1)");
}

}  // namespace colmap_ext
