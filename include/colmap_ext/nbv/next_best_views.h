// Where to take the next photos.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

// Constants of the paper (Sec. "NBV Planning and Flight Path Planning") unless the comment says
// "ours".
struct NextBestViewOptions {
  // Ours: "submodular". "plane_sweep": the paper's search. For comparison: "random",
  // "next_farthest_point", "hemisphere", "smith2018".
  std::string strategy = "submodular";

  // --- All strategies ---
  // Views of one plan, 1 … 1000. The paper takes 5 a plane, but flew about 11 an iteration (44
  // views in 4 flights of its church); with 12 ours is covered in as many.
  int num_views = 12;
  // Least distance of a view from the surface, metres, > 0 (the paper does not tell its value).
  double safe_distance_m = 5;
  // Ours: largest distance of a view from the surface, metres, >= 0; 0: no limit.
  double max_distance_m = 0;
  // Ours: views are not lower than this above the lowest iso-point that is not ignored, metres.
  double min_altitude_m = 2;
  // Ours: no view is higher than this z of the world, metres; 0: no limit.
  double max_altitude_m = 0;
  // Ours: what the gimbal can do, degrees, [-90, 90]. Pitches beyond are not tried.
  double min_gimbal_pitch_deg = -90;
  double max_gimbal_pitch_deg = 30;
  // Ours: points further away than this do not count, metres, > 0.
  double max_range_m = 100;
  // A pair of good views is within these angles at the point, degrees (paper: 2 and 30).
  double min_pair_angle_deg = 2;
  double max_pair_angle_deg = 30;
  // Ours: a score is lowered by up to this part, 0 … 1, for views that look towards the sun (0: the
  // sun does not matter). Azimuth clockwise from north, elevation above the horizon, degrees.
  double sun_weight = 0;
  double sun_azimuth_deg = 180;
  double sun_elevation_deg = 45;

  // Ours: registrability. A view must share at least this many features with existing or earlier
  // planned views, >= 0 (0: not asked), as predicted from the sparse points: see FeatureOverlap in
  // docs/algorithms.md. COLMAP registers a photo with 30 inliers.
  double min_shared_features = 80;
  // A feature is matched when the two views see it within this angle, degrees, (0, 90], and at
  // distances whose ratio is at most this, > 1.
  double max_feature_angle_deg = 25;
  double max_feature_scale = 1.8;

  // --- plane_sweep (the grid spacing, and nearness: bridges of submodular too) ---
  // Only the paper's search: its one plane a pitch, every uncovered point counts whatever its
  // ratio, no registrability, and none of what is "ours" below.
  bool paper_only = false;
  int num_pitches = 12;        // 1 … 180, evenly from min_pitch_deg to max_pitch_deg
  double min_pitch_deg = -30;  // (-90, 90)
  double max_pitch_deg = 30;   // (-90, 90), >= min_pitch_deg
  int num_yaws = 8;            // 1 … 360, evenly, the first one north
  double nms_radius_m = 1;     // chosen views are further apart than this, metres, >= 0
  // A view must be this near to an existing one, in yaw and in pitch (degrees, (0, 180]) and in
  // position (metres, > 0; indoors 0.5), so that SfM finds enough matches.
  double max_angle_to_existing_deg = 15;
  double max_distance_to_existing_m = 3;
  // Ours, the paper does not tell: spacing of the positions on a plane, metres, > 0.
  double grid_spacing_m = 1;
  // Ours: planes are searched at every so many-th position in x and y first, then around the best
  // ones at all, 1 … 8. 1: all at once.
  int coarse_step = 2;
  // Ours: planes other than the paper's are at multiples of this, metres, > 0.
  double plane_step_m = 1;
  // Ours: the first plane is accepted whose best view scores at least this part of the best of all
  // planes of that pitch, 0 … 1. 0: the first plane on which anything scores.
  double min_relative_score = 0.5;
  // Ours: a point counts only for views that help its stereo. 0: the paper.
  bool stereo_aware = true;
  // Ours: what a point still counts after the views chosen so far would cover it, 0 … 1. 1: the
  // paper, whose local maxima do not know of each other.
  double seen_weight = 0.1;
  // Ours: a view may also be near to a view chosen before it in the same plan (flown in one
  // flight).
  bool chain_views = false;
  // Ours: when a plane yields fewer than num_views, the others come from the next best planes.
  bool several_planes = true;
  // Ours: when no admissible view scores, lead to the nearest one that would, by a chain of views
  // that each are near to the one before.
  bool bridge = true;

  // --- submodular and those for comparison: the pool of candidate views ---
  int num_positions = 1200;  // 10 … 100000
  int views_a_position = 4;  // 1 … 32 directions kept at each
  int num_points = 1500;     // uncovered points are thinned to about this many, 100 … 1000000
  // Points are seen at this many times γ_min at least, 1 … 10: what is just good enough in the plan
  // may not be in the photo.
  double ratio_reserve = 1.1;
  // Budgets beside num_views; 0: none. Length (metres) and time (seconds of battery) of the tour
  // from where the vehicle is over all views; with return_to_start also back.
  double max_tour_length_m = 0;
  double max_tour_duration_s = 0;
  bool return_to_start = false;
  // What submodular adds to: "stereo", the paper's rule of a good pair; "predicted_error", how near
  // the predicted error of the best pair comes to that of a good one.
  std::string objective = "stereo";
  // A plan ends where the best view gains less than this part of the first one's gain, 0 … 1.
  double min_relative_gain = 0.05;
  // Of random, 1 …; ties elsewhere.
  std::uint64_t seed = 1;

  // The same as the coverage evaluation's; bound to the command line there.
  VisibilityOptions visibility;
  // The same as the path's; bound there.
  double speed_m_s = 3;        // > 0
  double yaw_rate_deg_s = 45;  // > 0
  double hover_s = 4;          // a photo, >= 0

  std::string Check() const;
};

// Section "NextBestView".
void BindOptions(OptionSet& set, NextBestViewOptions* options);

// What a plan starts from. World: ENU, metres. The references must outlive the call.
struct ViewPlanInput {
  const CoverageMap& coverage;  // its min_projection_ratio is γ_min
  const TriangleMesh& surface;
  const std::vector<PosedPhoto>& existing;  // all registered photos; pixels are not needed
  PinholeCamera camera = {};                // of the photos to come
  int first_id = 0;                         // id of the first view, counting up
  // Sparse points whose photo_indices refer to `existing`: the features to be matched. Fewer than
  // 100: iso-points stand for them.
  const std::vector<SupportPoint>* points = nullptr;
  // Views are only planned where it is true (null: everywhere). Give it the path planner's
  // FlyablePositions, else the loop can stall on views that no path leads to. Must be thread-safe.
  std::function<bool(const Eigen::Vector3d&)> may_fly = nullptr;
  // Views are only chosen where it is true (null: everywhere). Give it the path planner's
  // ReachablePositions, else the path stage drops views in pockets that no way leads to. Asked one
  // place at a time, after everything else.
  std::function<bool(const Eigen::Vector3d&)> may_reach = nullptr;
  const FlightLimits* limits = nullptr;  // null: none
  double limits_margin_m = 0;            // kept from them (position error), metres, >= 0
  std::optional<Eigen::Vector3d> start =
      std::nullopt;  // of the tour; absent: the last existing photo
};

struct ViewPlanResult {
  // plane_sweep: the best first; a bridge before them, in the order of flight. Others: in the order
  // of the tour.
  std::vector<PlannedView> views;
  std::size_t uncovered = 0;  // iso-points of that class
  // Uncovered iso-points that some candidate in free space sees with a projection ratio >= γ_min,
  // near to existing views or not. With stereo_aware, a candidate that repeats a good view that the
  // point has already is none: such a point cannot be covered.
  std::size_t reachable_uncovered = 0;
  double pitch_rad = 0;   // plane_sweep: of the (first) chosen plane; of the last view of a bridge
  double altitude_m = 0;  // z of the world, of the same
  bool is_bridge = false;
  // Features that each view is predicted to share with existing or earlier planned views, in the
  // order of `views`; -1 where it was not asked.
  std::vector<double> shared_features;
  // Of the straight tour from the start over `views` in their order, back when asked.
  double tour_length_m = 0;
  double tour_duration_s = 0;
  // "covered": nothing is uncovered. "nothing_reachable": no view was found. Else empty.
  std::string stop_reason;
  // Of "nothing_reachable": why, one line, for people.
  std::string explanation;
};

// Chooses views for what is not covered, by options.strategy (docs/algorithms.md):
//
// plane_sweep: for each pitch θ the plane at the altitude from which the highest uncovered
// iso-point (of those that are reachable) is seen in the middle of the image at the safe distance:
// z = z_p - d sin θ. On it a grid of positions, num_yaws headings each. A candidate is admissible
// when it is free and near to an existing view. Its score is the sum of the projection ratios of
// the uncovered iso-points that it sees (in the image, facing it, not hidden by `surface`). The
// num_views best with non-maximum suppression are taken, on the plane of the pitch whose best view
// scores highest. What we add so that the loop ends (each by option, see above):
// - An iso-point counts only where it is seen at a projection ratio >= γ_min (coverage's), since no
//   other view can make it covered; and, with stereo_aware, only for a view that is no repetition:
//   less than min_pair_angle_deg from a good view of the point, without making a good pair with
//   another, adds nothing. A point without any good view counts for all.
// - The altitude is limited to where the nearness to existing views (of similar pitch) permits a
//   view at all. From the paper's plane on, planes are tried downwards to the lowest such altitude,
//   and then upwards, every plane_step_m (min_relative_score): a high point that no view can
//   improve holds up nothing.
// - Points that the chosen views would cover count seen_weight for the next ones. A point that
//   needs two views goes on counting until it has both.
// - Bridges, see there.
// Ties go to the lower pitch, then the southern, western, first yaw.
//
// submodular: greedy maximisation of stereo coverage over a pool of views of any altitude and of
// all pitches of the gimbal, together with their tour.
//
// random, next_farthest_point: views of a pool that does not know what is covered; at random, or
// each time the one furthest from all views so far.
//
// hemisphere: views from a hemisphere over the model to its middle, each time the one furthest from
// all views so far.
//
// smith2018: greedy choice from that pool by the reconstructability heuristic of Smith et al. 2018
// (nbv/reconstructability.h), then each view is moved and turned while that raises it.
//
// All respect distances, altitudes, the gimbal, `limits`, `may_fly`, `may_reach` and
// registrability. Same result for any number of threads. Throws UsageError for bad options, Error
// when `existing` is empty.
ViewPlanResult PlanNextViews(const ViewPlanInput& input, const NextBestViewOptions& options,
                             const JobControl& job);

}  // namespace colmap_ext
