#include <cstdio>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "planning_inputs.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct PathPlannerPaths {
  std::filesystem::path workspace, input, mesh, views, output;
};

void CheckPaths(const PathPlannerPaths& paths) {
  RequireWorkspaceOrFiles(paths.workspace, {{"input_path", paths.input},
                                            {"mesh_path", paths.mesh},
                                            {"views_path", paths.views},
                                            {"output_path", paths.output}});
}

Eigen::Vector3d ParseStart(const std::string& text) {
  try {
    return ParsePlace(text);
  } catch (const UsageError& error) {
    throw UsageError(std::string("--start ") + error.what());
  }
}

void Report(const FlightPath& path, const std::filesystem::path& output, const JobControl& job) {
  if (path.waypoints.size() == 1) {
    job.Info("path_planner: nothing to fly: " +
             (path.dropped_view_ids.empty()
                  ? std::string("there are no views")
                  : "all " + std::to_string(path.dropped_view_ids.size()) +
                        " views were dropped, reasons above"));
  }
  char text[200];
  std::snprintf(text, sizeof text,
                "path_planner: %.1f m, %.0f s, clearance at least %.2f m, %zu views dropped: ",
                path.length_m, path.duration_s, path.min_clearance_m, path.dropped_view_ids.size());
  job.Info(text + output.string());
  for (std::size_t i = 0; i < path.flights.size(); ++i) {
    const BatteryFlight& flight = path.flights[i];
    std::snprintf(text, sizeof text,
                  "  flight %zu: waypoints %zu to %zu, %.1f m, %.0f s, %.0f s home, %.0f %% of a "
                  "battery",
                  i + 1, flight.first_waypoint, flight.last_waypoint, flight.length_m,
                  flight.duration_s, flight.return_s, 100 * flight.battery_share);
    job.Info(text);
  }
}

}  // namespace

int RunPathPlanner(const Arguments& arguments, Program& program) {
  CommandLine line("path_planner",
                   "Joins views to a path whose distance from the surface is proved; views that no "
                   "proved path reaches are dropped and named. --workspace_path: of the newest "
                   "iteration. Else from a sparse model in metres (--input_path), its surface "
                   "(--mesh_path) and views (--views_path) to path.json (--output_path). The path "
                   "starts at the last photo, or at --start.");
  PathPlannerPaths paths;
  PathOptions options;
  std::string start_text;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "folder of a sparse model");
  line.options().Add("", "mesh_path", &paths.mesh, "PLY file of the surface");
  line.options().Add("", "views_path", &paths.views, "views.json");
  line.options().Add("", "output_path", &paths.output, "path.json to write");
  line.options().Add("", "start", &start_text, "x,y,z where the vehicle is, world, metres");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckPaths(paths);

  const JobControl job = program.Job();
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    const IterationFiles files = LatestIterationFiles(workspace);
    paths = {paths.workspace, files.sparse(), files.surface_ply(), files.views_json(),
             files.path_json()};
  }
  const std::vector<PlannedView> views = ReadViews(paths.views);
  const PlanningInputs inputs = ReadPlanningInputs(paths.input, paths.mesh, 0);
  ReadZones(inputs.frame, &options);
  ReadVouchedPhotos(paths.workspace, &options);
  const Eigen::Vector3d start = start_text.empty()
                                    ? CameraCenter(inputs.photos.photos.back().cam_from_world)
                                    : ParseStart(start_text);
  const FlightPath path = PlanPath(start, views, ConfidentSurface(inputs, paths.mesh, options, job),
                                   inputs.photos.photos, options, job);
  WritePath(path, inputs.frame, paths.output);
  Report(path, paths.output, job);
  program.log.Result({{"waypoints", path.waypoints.size()},
                      {"length_m", path.length_m},
                      {"duration_s", path.duration_s},
                      {"min_clearance_m", path.min_clearance_m},
                      {"dropped_view_ids", path.dropped_view_ids},
                      {"flights", path.flights.size()},
                      {"output_path", paths.output.string()}});
  return 0;
}

}  // namespace colmap_ext
