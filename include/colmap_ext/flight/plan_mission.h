// A planned path to a mission for the daemon: limits, fence, transit height.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct FlightPlanOptions {
  // The fence is the rectangle around home, views and site, this much larger, metres, [1, 1000].
  double fence_margin_m = 20;
  // Ways that the planner did not plan go this much above everything, metres, [0, 100].
  double transit_margin_m = 5;
  double max_relative_height_m =
      120;  // above home, metres, (0, 500]; 120 is the law in many places
  double min_relative_height_m = 1.5;  // above home, metres, [0.1, 50]
  double max_distance_m = 500;         // from home, metres, [1, 10000]
  double undulation_m = 0;             // height of the frame's datum above mean sea level's, metres

  std::string Check() const;
};

// Section "FlightPlan".
void BindOptions(OptionSet& set, FlightPlanOptions* options);

// What the mission is made from beside the path.
struct FlightSite {
  WorldFrame frame;
  BoundingBox box;                     // of what is there, world; the surface or the region
  std::filesystem::path surface_path;  // see FlightMission
  FlightLimits limits;                 // geofence, no-fly zones, altitudes
  double safe_distance_m = 5;          // that `path` keeps
  double speed_m_s = 3;
  std::optional<Eigen::Vector3d> home;  // world, where it is known
  bool full_resolution = false;
};

// `photo_name` gives a view's file name. The first waypoint of a path is where the vehicle was, and
// flown through. Throws UsageError for bad options, Error for a frame without metres or origin.
FlightMission PlanFlightMission(const FlightPath& path, const FlightSite& site,
                                const std::function<std::string(int view_id)>& photo_name,
                                const FlightPlanOptions& options);

// The checklist before a vehicle arms: views, metres, minutes, batteries, heights, nearest
// obstacle.
struct FlightChecklist {
  int views = 0;
  double length_m = 0;   // from the first stop to the last
  double minutes = 0;    // with a stop at every view, take-off and return
  double batteries = 0;  // of 100 % each, less the reserve
  double lowest_m = 0;   // above home (above the world's z = 0 where home is not known)
  double highest_m = 0;
  std::optional<double> nearest_m;  // proved least distance from the surface; absent: no surface
};
FlightChecklist MakeChecklist(const FlightMission& mission, double percent_per_minute,
                              double reserve_percent);
// Lines of text, with line ends.
std::string ChecklistText(const FlightChecklist& checklist, const FlightMission& mission);

}  // namespace colmap_ext
