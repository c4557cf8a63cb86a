#include <algorithm>
#include <cstdio>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/mission/flight_patterns.h"
#include "colmap_ext/path/clearance.h"
#include "colmap_ext/path/flight_time.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct FlightPlannerInputs {
  std::filesystem::path workspace, mesh, polygon, frame, views, output;
  double min_z_m = 0;
  double max_z_m = 10;
};

void BindInputs(OptionSet& set, FlightPlannerInputs* inputs) {
  set.Add("", "workspace_path", &inputs->workspace, "session: around its region of interest");
  set.Add("", "mesh_path", &inputs->mesh, "PLY of a model: around its bounds, or checked against");
  set.Add("", "polygon_path", &inputs->polygon, "GeoJSON: around its first polygon");
  set.Add("", "frame_path", &inputs->frame, "frame.json of the world; needed for longitudes");
  set.Add("", "min_z_m", &inputs->min_z_m, "bottom of a polygon without heights (z of the world)");
  set.Add("", "max_z_m", &inputs->max_z_m, "top of a polygon without heights (z of the world)");
  set.Add("", "views_path", &inputs->views, "views.json to write");
  set.Add("", "output_path", &inputs->output, "path.json to write");
}

WorldFrame FrameOf(const FlightPlannerInputs& inputs) {
  if (!inputs.frame.empty()) return ReadWorldFrame(inputs.frame);
  if (!inputs.workspace.empty()) {
    return FrameOrMetric(LatestIterationFiles(Workspace(inputs.workspace)).frame_json());
  }
  return {true, std::nullopt};
}

PatternSite SiteOf(const FlightPlannerInputs& inputs, const RegionOptions& region,
                   const WorldFrame& frame) {
  if (!region.box.empty()) return SiteOfBox(ParseBox(region.box));
  if (!inputs.polygon.empty()) {
    const FlightLimits polygons = ReadFlightLimits(inputs.polygon, frame);
    if (polygons.zones.empty()) throw Error(inputs.polygon.string() + ": no polygon");
    return SiteOfZone(polygons.zones.front(), inputs.min_z_m, inputs.max_z_m);
  }
  if (!inputs.workspace.empty()) {
    return SiteOfBox(RegionOfWorkspace(Workspace(inputs.workspace), region).box);
  }
  if (!inputs.mesh.empty()) return SiteOfBox(BoundsOf(ReadMesh(inputs.mesh)));
  throw UsageError(
      "what to fly around? give --RegionOfInterest.box, --polygon_path, --workspace_path or "
      "--mesh_path");
}

// Views that a limit forbids are left out and named.
std::vector<PlannedView> AllowedViews(const std::vector<PlannedView>& views,
                                      const PathOptions& options, const JobControl& job) {
  std::vector<PlannedView> allowed;
  for (const PlannedView& view : views) {
    std::string why = options.limits.WhyNot(view.position);
    if (options.max_altitude_m != 0 && view.position.z() > options.max_altitude_m) {
      why = "above the ceiling";
    }
    if (why.empty()) {
      allowed.push_back(view);
    } else {
      job.Warn("flight_planner: view " + std::to_string(view.id) + " is left out: it is " + why);
    }
  }
  if (allowed.empty()) throw Error("the flight limits forbid every view of the pattern");
  return allowed;
}

// Says what a pattern does not prove by itself.
void CheckPath(const FlightPlannerInputs& inputs, const PathOptions& options, const JobControl& job,
               FlightPath* path) {
  std::vector<Eigen::Vector3d> line;
  for (const Waypoint& waypoint : path->waypoints) line.push_back(waypoint.position);
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    if (options.limits.AllowsSegment(line[i], line[i + 1], 0)) continue;
    job.Warn("flight_planner: from waypoint " + std::to_string(i) +
             " to the next the straight way leaves the flight limits; give views.json to "
             "path_planner");
  }
  if (inputs.mesh.empty()) {
    job.Warn("flight_planner: nothing is known about obstacles: the pilot vouches for this path");
    return;
  }
  const RayScene model(ReadMesh(inputs.mesh));
  path->min_clearance_m =
      std::max(0.0, ProvedMinClearance(model, line, 0.02, 50) - options.position_error_m);
  if (path->min_clearance_m < options.safe_distance_m) {
    job.Warn(
        "flight_planner: the path is nearer to the model than the safe distance; give views.json "
        "to path_planner, or raise --Pattern.distance_m");
  }
}

}  // namespace

int RunFlightPlanner(const Arguments& arguments, Program& program) {
  CommandLine line("flight_planner",
                   "Plans a classic flight pattern (--Pattern.name) around a box "
                   "(--RegionOfInterest.box), a polygon, the region of a session, or a model: "
                   "views.json and path.json. Photos by overlap, or by count "
                   "(--Pattern.num_views).");
  FlightPlannerInputs inputs;
  FlightPatternOptions pattern;
  RegionOptions region;
  PathOptions options;
  BindInputs(line.options(), &inputs);
  BindOptions(line.options(), &pattern);
  BindOptions(line.options(), &region);
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  RequireOption(inputs.views, "views_path");
  RequireOption(inputs.output, "output_path");
  ThrowIfInvalid(options.Check());

  const JobControl job = program.Job();
  const WorldFrame frame = FrameOf(inputs);
  RequireMetric(frame);
  ReadZones(frame, &options);
  const std::vector<PlannedView> views =
      AllowedViews(MakeFlightPattern(SiteOf(inputs, region, frame), pattern), options, job);
  FlightPath path = FlyInOrder(views, options);
  CheckPath(inputs, options, job, &path);
  WriteViews(views, frame, inputs.views);
  WritePath(path, frame, inputs.output);
  char text[200];
  std::snprintf(text, sizeof text,
                "flight_planner: %zu views, %.1f m, %.0f s, %zu flights, clearance %.2f m proved",
                views.size(), path.length_m, path.duration_s, path.flights.size(),
                path.min_clearance_m);
  job.Info(text);
  program.log.Result({{"views", views.size()},
                      {"length_m", path.length_m},
                      {"duration_s", path.duration_s},
                      {"flights", path.flights.size()},
                      {"min_clearance_m", path.min_clearance_m},
                      {"views_path", inputs.views.string()},
                      {"output_path", inputs.output.string()}});
  return 0;
}

}  // namespace colmap_ext
