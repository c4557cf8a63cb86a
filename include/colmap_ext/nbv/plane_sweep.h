// Where to take the next photos: the paper's search, plane by plane from high to low.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

// Constants of the paper (Sec. "NBV Planning and Flight Path Planning") unless the comment says
// "ours".
struct NextBestViewOptions {
  int num_pitches = 12;        // 1 … 180, evenly from min_pitch_deg to max_pitch_deg
  double min_pitch_deg = -30;  // (-90, 90)
  double max_pitch_deg = 30;   // (-90, 90), >= min_pitch_deg
  int num_yaws = 8;            // 1 … 360, evenly, the first one north
  // Views of one plan, 1 … 1000. The paper takes 5 a plane, but flew about 11 an iteration (44
  // views in 4 flights of its church); with 12 ours is covered in as many.
  int num_views = 12;
  double nms_radius_m = 1;  // chosen views are further apart than this, metres, >= 0
  // A view must be this near to an existing one, in yaw and in pitch (degrees, (0, 180]) and in
  // position (metres, > 0; indoors 0.5), so that SfM finds enough matches.
  double max_angle_to_existing_deg = 15;
  double max_distance_to_existing_m = 3;
  // Least distance of a view from the surface, metres, > 0 (the paper does not tell its value).
  double safe_distance_m = 5;
  // Ours, the paper does not tell: spacing of the positions on a plane, metres, > 0.
  double grid_spacing_m = 1;
  // Ours: planes other than the paper's are at multiples of this, metres, > 0.
  double plane_step_m = 1;
  // Ours: the first plane is accepted whose best view scores at least this part of the best of all
  // planes of that pitch, 0 … 1. 0: the first plane on which anything scores.
  double min_relative_score = 0.5;
  // Ours: views are not lower than this above the lowest iso-point that is not ignored, metres.
  double min_altitude_m = 2;
  // Ours: no view is higher than this z of the world, metres; 0: no limit.
  double max_altitude_m = 0;
  // Ours: points further away than this do not count, metres, > 0.
  double max_range_m = 100;
  // Ours: a point counts only for views that help its stereo, see PlanNextViews. 0: the paper.
  bool stereo_aware = true;
  // A pair of good views is within these angles at the point, degrees (paper: 2 and 30).
  double min_pair_angle_deg = 2;
  double max_pair_angle_deg = 30;
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

  // The same as the coverage evaluation's; bound to the command line there.
  VisibilityOptions visibility;

  std::string Check() const;
};

// Section "NextBestView".
void BindOptions(OptionSet& set, NextBestViewOptions* options);

struct ViewPlanResult {
  std::vector<PlannedView> views;  // the best first; a bridge before them, in the order of flight
  std::size_t uncovered = 0;       // iso-points of that class
  // Uncovered iso-points that some candidate in free space sees with a projection ratio >= γ_min,
  // near to existing views or not. With stereo_aware, a candidate that repeats a good view that the
  // point has already is none: such a point cannot be covered.
  std::size_t reachable_uncovered = 0;
  double pitch_rad = 0;   // of the (first) chosen plane; of the last view of a bridge
  double altitude_m = 0;  // z of the world, of the same
  bool is_bridge = false;
  // "covered": nothing is uncovered. "nothing_reachable": no view was found. Else empty.
  std::string stop_reason;
};

// For each pitch θ the plane at the altitude from which the highest uncovered iso-point (of those
// that are reachable) is seen in the middle of the image at the safe distance: z = z_p - d sin θ.
// On it a grid of positions, num_yaws headings each. A candidate is admissible when it is free
// (safe distance from the surface, altitude limits) and near to an existing view. Its score is the
// sum of the projection ratios of the uncovered iso-points that it sees (in the image, facing it,
// not hidden by `surface`). The num_views best with non-maximum suppression are taken, on the plane
// of the pitch whose best view scores highest.
//
// What we add so that the loop ends (each by option, see above):
// - An iso-point counts only where it is seen at a projection ratio >= γ_min (coverage's), since no
// other
//   view can make it covered; and, with stereo_aware, only for a view that is no repetition: less
//   than min_pair_angle_deg from a good view of the point, without making a good pair with
//   another, adds nothing. A point without any good view counts for all.
// - The altitude is limited to where the nearness to existing views (of similar pitch) permits a
// view
//   at all. From the paper's plane on, planes are tried downwards to the lowest such altitude, and
//   then upwards, every plane_step_m (min_relative_score): a high point that no view can improve
//   holds up nothing.
// - Points that the chosen views would cover count seen_weight for the next ones. A point that
// needs
//   two views goes on counting until it has both.
// - Bridges, see there.
// - `may_fly`: views are only planned where it is true (null: everywhere). Give it the path
// planner's
//   FlyablePositions, else the loop can stall on views that no path leads to. Must be thread-safe.
// Ties go to the lower pitch, then the southern, western, first yaw.
//
// `coverage.min_projection_ratio` is γ_min. `existing`: all registered photos. `camera`: of the
// photos to come. `first_id`: id of the first view, counting up. World: ENU, metres. Same result
// for any number of threads. Throws UsageError for bad options, Error when `existing` is empty.
ViewPlanResult PlanNextViews(const CoverageMap& coverage, const TriangleMesh& surface,
                             const std::vector<PosedPhoto>& existing, const PinholeCamera& camera,
                             int first_id, const NextBestViewOptions& options,
                             const JobControl& job,
                             const std::function<bool(const Eigen::Vector3d&)>& may_fly = nullptr);

}  // namespace colmap_ext
