#include <cmath>
#include <cstdio>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "planning_inputs.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct Paths {
  std::filesystem::path workspace, input, mesh, views, output;
};

void CheckPaths(const Paths& paths) {
  RequireWorkspaceOrFiles(paths.workspace, {{"input_path", paths.input},
                                            {"mesh_path", paths.mesh},
                                            {"views_path", paths.views},
                                            {"output_path", paths.output}});
}

// "x,y,z"
Eigen::Vector3d ParsePosition(const std::string& text) {
  Eigen::Vector3d position;
  char rest = 0;
  const int count = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &position.x(), &position.y(),
                                &position.z(), &rest);
  if (count != 3 || !position.allFinite()) {
    throw UsageError("--start " + text + ": must be x,y,z in metres");
  }
  return position;
}

}  // namespace

int RunPathPlanner(const Arguments& arguments, const CancelFlag& cancel) {
  CommandLine line("path_planner",
                   "Joins views to a path whose distance from the surface is proved; views that no "
                   "proved path reaches are dropped and named. --workspace_path: of the newest "
                   "iteration. Else from a sparse model in metres (--input_path), its surface "
                   "(--mesh_path) and views (--views_path) to path.json (--output_path). The path "
                   "starts at the last photo, or at --start.");
  Paths paths;
  PathOptions options;
  std::string start_text;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "folder of a sparse model");
  line.options().Add("", "mesh_path", &paths.mesh, "PLY file of the surface");
  line.options().Add("", "views_path", &paths.views, "views.json");
  line.options().Add("", "output_path", &paths.output, "path.json to write");
  line.options().Add("", "start", &start_text, "x,y,z where the vehicle is, world, metres");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments)) return 0;
  CheckPaths(paths);

  ConsoleSink sink(line.log_level());
  const JobControl job(&sink, &cancel);
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    const IterationFiles files = LatestIterationFiles(workspace);
    paths = {paths.workspace, files.sparse(), files.surface_ply(), files.views_json(),
             files.path_json()};
  }
  const std::vector<PlannedView> views = ReadViews(paths.views);
  const PlanningInputs inputs = ReadPlanningInputs(paths.input, paths.mesh, 0);
  const Eigen::Vector3d start = start_text.empty()
                                    ? CameraCenter(inputs.photos.photos.back().cam_from_world)
                                    : ParsePosition(start_text);
  const FlightPath path =
      PlanPath(start, views, inputs.surface, inputs.photos.photos, options, job);
  WritePath(path, inputs.frame, paths.output);
  char text[160];
  std::snprintf(text, sizeof text,
                "path_planner: %.1f m, %.0f s, clearance at least %.2f m, %zu views dropped: ",
                path.length_m, path.duration_s, path.min_clearance_m, path.dropped_view_ids.size());
  job.Info(text + paths.output.string());
  return 0;
}

}  // namespace colmap_ext
