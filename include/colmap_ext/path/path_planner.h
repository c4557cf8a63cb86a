// Joins planned views to a flight that is proved to keep its distance from the surface.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/path/free_space.h"
#include "colmap_ext/path/segment_check.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct PathOptions {
  // Least distance of the vehicle from the surface anywhere on the path, metres, > 0. Paper: its
  // "safe distance".
  double safe_distance_m = 5;
  // The vehicle may be so far from the planned line (positioning, control, wind), metres, >= 0: the
  // line keeps the safe distance + this. The flight daemon waits until it is within 0.5 m of a
  // view.
  double position_error_m = 0.5;
  // Cells of the search grid, metres, > 0.
  double cell_size_m = 1;
  // How far beyond start, views and surface top the grid goes, for detours, metres, >= 0.
  double detour_margin_m = 10;
  // Ceiling: highest z of the world that may be flown, metres; 0: none.
  double max_altitude_m = 0;
  // "occupied": space that nothing is known about is not flown through; "free": it is.
  std::string unknown = "occupied";
  // What the pilot vouches for: see SetFreeVolume.
  std::string free_volume = "flown;above_top";
  // GeoJSON of geofence and no-fly zones (ReadFlightLimits); empty: none.
  std::filesystem::path limits_path;
  // See FreeSpaceOptions, metres, >= 0. The vouched flight is vouched to keep the safe distance
  // from everything. Less than the next best views' max_distance_to_existing_m makes the loop slow.
  double flown_margin_m = 5;
  // Names of the photos (one a line, as COLMAP's image lists) of flights that a person planned and
  // vouches for: see vouched_photos. Empty: as vouch_planned_flights says; without a session, all.
  std::filesystem::path vouched_image_list_path;
  // A session's planned flights vouch for what is around them, too, so what is taken for free grows
  // with every flight. Without, only its first iteration's photos do: safer, but a vehicle that is
  // off its place by more than it should be may find no proved way on, and the session ends early.
  bool vouch_planned_flights = true;
  // See FreeSpaceOptions, metres, >= 0; 0: all of the surface is confident. After a first flight
  // 99 % of the church's surface is denser than 0.85 m; what is sparser is guessed.
  double confident_spacing_m = 1;
  // The vehicle is where it is: its place may be nearer to the surface than the safe distance and
  // position error by this, metres, >= 0. It then leaves by a straight leg that never gets nearer
  // than it is. Where what is known to be free begins no further than this and 2 position_error_m
  // from it, it leaves by a straight leg there.
  double start_tolerance_m = 1;
  // Views and legs nearer than safe_distance_m + position_error_m + this are not proved, metres,
  // 0.002 … 1. Smaller values take more distance queries.
  double proof_tolerance_m = 0.02;
  // For the estimate of time and battery, see TimeBetween.
  double speed_m_s = 3;            // level, (0, 30]
  double climb_speed_m_s = 2;      // (0, 30]
  double descent_speed_m_s = 1.5;  // (0, 30]
  double acceleration_m_s2 = 2;    // (0, 30]
  double yaw_rate_deg_s = 45;      // (0, 360]
  double hover_s = 4;              // a photo: settling, aiming, capture; >= 0
  double takeoff_landing_s = 40;   // both together, a flight; >= 0
  // Flying time of a full battery, seconds, >= 0; 0: no limit.
  double battery_s = 1200;
  // Part of the battery that is left when the vehicle has landed, [0, 1).
  double battery_reserve = 0.25;
  // Where batteries are changed, "x,y,z", world, metres: the hover above the take-off place. Empty:
  // where the path starts.
  std::string home;
  // The path ends at home; else at the last view, with the way home reckoned in the battery.
  bool return_home = false;

  // What the files that limits_path and free_volume name hold: see ReadZones. Not bound to the
  // command line.
  FlightLimits limits;
  std::vector<FlightZone> free_zones;
  // Only around these photos does flown_margin_m count; where others were taken there is room for
  // the vehicle to hold its place (2 position_error_m) and what they saw, no more: so what is taken
  // for free does not grow by our own flights. Absent: all photos. Not bound to the command line.
  std::optional<std::set<std::string>> vouched_photos;

  std::string Check() const;
};

// Section "Path".
void BindOptions(OptionSet& set, PathOptions* options);

// "x,y,z", metres. Throws UsageError naming the text otherwise.
Eigen::Vector3d ParsePlace(const std::string& text);

// Throws Error when the world is not metric with z up: distances mean nothing then.
void RequireMetric(const WorldFrame& frame);

// Reads the files that limits_path and free_volume name. Throws as ReadFlightLimits.
void ReadZones(const WorldFrame& frame, PathOptions* options);

// Sets vouched_photos from vouched_image_list_path, or, when that is empty and planned flights do
// not vouch, to the first flight's of the session in `workspace` (empty: all photos are vouched
// for). Throws as ReadImageList and FirstFlightPhotos.
void ReadVouchedPhotos(const std::filesystem::path& workspace, PathOptions* options);

// What PlanPath knows to be free around `surface` (world). `photos`: all registered ones, without
// pixels; what they saw is free, and where they were, as options.vouched_photos says. `start` is a
// place that was visited. Throws UsageError for bad options.
FreeSpace KnownSpace(const Surface& surface, const std::vector<PosedPhoto>& photos,
                     const Eigen::Vector3d& start, const PathOptions& options);

// What each straight piece of a path keeps.
SegmentRules RulesOf(const PathOptions& options);

// Plans a path from `start` (world) over as many of `views` as can be reached (paper, Sec. "NBV
// Planning and Flight Path Planning"; order and proofs: docs/algorithms.md).
// 1. Cells nearer than the safe distance to the surface, unknown ones (see FreeSpace) and those
//    beyond the limits are occupied. A straight leg between two views is taken where it can be
//    proved; else A* finds the shortest way through free cells, in three dimensions, each step
//    proved; the way is then pulled straight, and each new segment proved again.
// 2. Order: nearest neighbour by length of the legs, then 2-opt and Or-opt.
// 3. Batteries: before the way home would take more than the battery has, it is flown (proved as
//    every leg is) and the next flight begins there. waypoints is the whole of it, without a gap.
// 4. min_clearance_m is a proved lower bound for the vehicle over the whole path (at most 50 m):
//    that of the line less position_error_m.
// Views that break a rule, are not reached by a proved leg, or are further than a battery carries
// are dropped: named in `dropped_view_ids` (in the order of `views`) with `drop_reasons`, each also
// a warning to `job`. The first waypoint is `start` (view_id -1). Each waypoint without a view has
// the direction of the next view. No views: a path of the start alone. Throws UsageError for bad
// options, Error when `start` breaks a rule (but see start_tolerance_m), no way home is found, or
// the grid would have more than 200 million cells.
FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const FreeSpace& space, const PathOptions& options, const JobControl& job);

// The same, all in one. A bare mesh is confident everywhere.
FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const Surface& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job);
FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job);

// Where PlanPath would let the vehicle hover, for the search of views: clearance, known space and
// limits as there (that a way leads to the place is not looked at). Thread-safe; shares `space`, or
// holds copies of what it needs. Throws UsageError for bad options.
std::function<bool(const Eigen::Vector3d&)> FlyablePositions(std::shared_ptr<const FreeSpace> space,
                                                             const PathOptions& options);
std::function<bool(const Eigen::Vector3d&)> FlyablePositions(const TriangleMesh& surface,
                                                             const std::vector<PosedPhoto>& photos,
                                                             const Eigen::Vector3d& start,
                                                             const PathOptions& options);

// Whether PlanPath would find a proved way from `start` to a place where the vehicle may hover, for
// the choice of views: a straight one, or one through free cells around the surface and the places
// flown so far. What is found out about a cell is kept; still much slower than FlyablePositions, so
// ask it only of what would be chosen. From a start that PlanPath refuses every way counts as
// found: PlanPath says why. Thread-safe (one at a time). Throws UsageError for bad options, Error
// as PlanPath for a grid that is too large.
std::function<bool(const Eigen::Vector3d&)> ReachablePositions(
    std::shared_ptr<const FreeSpace> space, const Eigen::Vector3d& start,
    const PathOptions& options);

}  // namespace colmap_ext
