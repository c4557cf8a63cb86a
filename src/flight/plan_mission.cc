#include "colmap_ext/flight/plan_mission.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/path/clearance.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kPhotoS = 8;      // settling, aiming, capture
constexpr double kFurthestM = 50;  // distances beyond are not told apart
constexpr double kProofToleranceM = 0.05;

std::vector<Eigen::Vector2d> Rectangle(const BoundingBox& box, double margin_m) {
  const Eigen::Vector2d low = box.min().head<2>().array() - margin_m;
  const Eigen::Vector2d high = box.max().head<2>().array() + margin_m;
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

}  // namespace

std::string FlightPlanOptions::Check() const {
  if (!(fence_margin_m >= 1 && fence_margin_m <= 1000)) {
    return "FlightPlan.fence_margin_m must be from 1 to 1000";
  }
  if (!(transit_margin_m >= 0 && transit_margin_m <= 100)) {
    return "FlightPlan.transit_margin_m must be from 0 to 100";
  }
  if (!(max_relative_height_m > 0 && max_relative_height_m <= 500)) {
    return "FlightPlan.max_relative_height_m must be above 0 and at most 500";
  }
  if (!(min_relative_height_m >= 0.1 && min_relative_height_m <= 50)) {
    return "FlightPlan.min_relative_height_m must be from 0.1 to 50";
  }
  if (!(max_distance_m >= 1 && max_distance_m <= 10000)) {
    return "FlightPlan.max_distance_m must be from 1 to 10000";
  }
  if (!std::isfinite(undulation_m)) return "FlightPlan.undulation_m must be a finite number";
  return "";
}

void BindOptions(OptionSet& set, FlightPlanOptions* options) {
  set.Add("FlightPlan", "fence_margin_m", &options->fence_margin_m,
          "the fence is so much larger than home, views and site [m, 1 … 1000]");
  set.Add("FlightPlan", "transit_margin_m", &options->transit_margin_m,
          "ways that nobody planned go so much above everything [m, 0 … 100]");
  set.Add("FlightPlan", "max_relative_height_m", &options->max_relative_height_m,
          "above home [m, up to 500]");
  set.Add("FlightPlan", "min_relative_height_m", &options->min_relative_height_m,
          "above home [m, 0.1 … 50]");
  set.Add("FlightPlan", "max_distance_m", &options->max_distance_m, "from home [m, 1 … 10000]");
  set.Add("FlightPlan", "undulation_m", &options->undulation_m,
          "height of zero in the photos' positions above mean sea level's zero [m]");
}

FlightMission PlanFlightMission(const FlightPath& path, const FlightSite& site,
                                const std::function<std::string(int)>& photo_name,
                                const FlightPlanOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!site.frame.is_metric_enu) throw Error("no flight: the world is not in metres");
  if (!site.frame.origin) throw Error("no flight: the world has no place on Earth");
  FlightMission mission;
  mission.origin = *site.frame.origin;
  mission.undulation_m = options.undulation_m;
  mission.speed_m_s = site.speed_m_s;
  mission.safe_distance_m = site.safe_distance_m;
  mission.surface_path = site.surface_path;
  mission.is_vouched = site.surface_path.empty();
  mission.full_resolution = site.full_resolution;
  if (site.home) mission.home_z_m = site.home->z();
  BoundingBox space = site.box;
  if (site.home) space.extend(*site.home);
  for (const Waypoint& waypoint : path.waypoints) {
    FlightStop stop;
    stop.position = waypoint.position;
    stop.direction = waypoint.direction;
    stop.view_id = waypoint.view_id;
    if (stop.view_id >= 0) stop.photo = photo_name(stop.view_id);
    mission.stops.push_back(stop);
    space.extend(waypoint.position);
  }
  mission.transit_z_m = space.max().z() + options.transit_margin_m;
  if (!site.box.isEmpty()) {
    mission.transit_z_m = std::max(*mission.transit_z_m, site.box.max().z() + site.safe_distance_m);
  }
  mission.limits.min_relative_height_m = options.min_relative_height_m;
  mission.limits.max_relative_height_m = options.max_relative_height_m;
  mission.limits.max_distance_m = options.max_distance_m;
  mission.limits.fence = Rectangle(space, options.fence_margin_m);
  mission.limits.site = site.limits;
  return mission;
}

FlightChecklist MakeChecklist(const FlightMission& mission, double percent_per_minute,
                              double reserve_percent) {
  FlightChecklist list;
  std::vector<Eigen::Vector3d> line;
  double low = INFINITY, high = -INFINITY;
  for (const FlightStop& stop : mission.stops) {
    if (!line.empty()) list.length_m += (stop.position - line.back()).norm();
    line.push_back(stop.position);
    low = std::min(low, stop.position.z());
    high = std::max(high, stop.position.z());
    list.views += stop.view_id >= 0 ? 1 : 0;
  }
  if (line.empty()) return list;
  const double home_z_m = mission.home_z_m.value_or(0);
  list.lowest_m = low - home_z_m;
  list.highest_m = high - home_z_m;
  const double way_home_m = 2 * list.highest_m;  // up and down, at 1 m/s
  list.minutes = (list.length_m / mission.speed_m_s + kPhotoS * list.views + way_home_m) / 60;
  list.batteries = list.minutes * percent_per_minute / (100 - reserve_percent);
  if (!mission.surface_path.empty()) {
    const RayScene surface(ReadMesh(mission.surface_path));
    list.nearest_m = ProvedMinClearance(surface, line, kProofToleranceM, kFurthestM);
  }
  return list;
}

std::string ChecklistText(const FlightChecklist& list, const FlightMission& mission) {
  char text[600];
  std::snprintf(text, sizeof text,
                "  views               %d\n"
                "  way                 %.0f m at %.1f m/s\n"
                "  time                %.1f minutes\n"
                "  batteries           %.1f\n"
                "  height above home   %.1f m to %.1f m\n",
                list.views, list.length_m, mission.speed_m_s, list.minutes, list.batteries,
                list.lowest_m, list.highest_m);
  std::string lines = text;
  if (list.nearest_m) {
    std::snprintf(text, sizeof text,
                  "  nearest obstacle    %.2f m (proved, to the known surface)\n", *list.nearest_m);
    lines += text;
  } else {
    lines += "  nearest obstacle    not known: you vouch for the way\n";
  }
  if (mission.transit_z_m) {
    std::snprintf(text, sizeof text, "  transit height      %.1f m above home\n",
                  *mission.transit_z_m - mission.home_z_m.value_or(0));
    lines += text;
  }
  return lines;
}

}  // namespace colmap_ext
