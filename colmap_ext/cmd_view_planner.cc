#include <algorithm>
#include <cmath>
#include <memory>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/coverage_map_io.h"
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

struct ViewPlannerPaths {
  std::filesystem::path workspace, input, mesh, coverage, output;
};

void CheckPaths(const ViewPlannerPaths& paths) {
  RequireWorkspaceOrFiles(paths.workspace, {{"input_path", paths.input},
                                            {"mesh_path", paths.mesh},
                                            {"coverage_path", paths.coverage},
                                            {"output_path", paths.output}});
}

std::string Describe(const ViewPlanResult& plan) {
  return "view_planner: " + std::to_string(plan.views.size()) + " views; " +
         std::to_string(plan.uncovered) + " iso-points uncovered, " +
         std::to_string(plan.reachable_uncovered) + " of them reachable" + "; a tour of " +
         std::to_string(std::lround(plan.tour_length_m)) + " m, " +
         std::to_string(std::lround(plan.tour_duration_s)) + " s" +
         (plan.stop_reason.empty() ? "" : "; " + plan.stop_reason);
}

}  // namespace

int RunViewPlanner(const Arguments& arguments, Program& program) {
  CommandLine line(
      "view_planner",
      "Chooses the next best views for what is not covered yet. --workspace_path: of the "
      "newest iteration. Else from a sparse model in metres (--input_path), its surface "
      "(--mesh_path) and coverage map (--coverage_path) to views.json (--output_path).");
  ViewPlannerPaths paths;
  NextBestViewOptions options;
  PathOptions path_options;          // views are chosen where a path may lead
  CoverageOptions coverage_options;  // and see what coverage says that they see
  int max_width_px = 0;
  int first_id = 0;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "folder of a sparse model");
  line.options().Add("", "mesh_path", &paths.mesh, "PLY file of the surface");
  line.options().Add("", "coverage_path", &paths.coverage, "PLY file of the coverage map");
  line.options().Add("", "output_path", &paths.output, "views.json to write");
  line.options().Add("", "max_image_size_px", &max_width_px,
                     "width of the photos that coverage was judged with; 0: of the session");
  line.options().Add("", "first_id", &first_id, "id of the first planned view [>= 0]");
  BindOptions(line.options(), &options);
  BindOptions(line.options(), &path_options);
  BindOptions(line.options(), &coverage_options);
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckPaths(paths);
  if (max_width_px < 0) throw UsageError("--max_image_size_px must not be negative");
  if (first_id < 0) throw UsageError("--first_id must not be negative");

  const JobControl job = program.Job();
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    const IterationFiles files = LatestIterationFiles(workspace);
    paths = {paths.workspace, files.sparse(), files.surface_ply(), files.coverage_ply(),
             files.views_json()};
    if (max_width_px == 0) max_width_px = SessionImageWidth(workspace);
    // The views replace those that the session planned, so they take their ids.
    if (std::filesystem::exists(paths.output) && first_id == 0) {
      for (const PlannedView& view : ReadViews(paths.output)) {
        first_id = first_id == 0 ? view.id : std::min(first_id, view.id);
      }
    }
  }
  const PlanningInputs inputs = ReadPlanningInputs(paths.input, paths.mesh, max_width_px);
  const std::vector<PosedPhoto>& photos = inputs.photos.photos;
  options.visibility = coverage_options.visibility;
  options.speed_m_s = path_options.speed_m_s;
  options.yaw_rate_deg_s = path_options.yaw_rate_deg_s;
  options.hover_s = path_options.hover_s;
  ReadZones(inputs.frame, &path_options);
  ReadVouchedPhotos(paths.workspace, &path_options);
  const CoverageMap coverage = ReadCoverageMap(paths.coverage);
  ViewPlanInput input{coverage, inputs.surface, photos};
  input.camera = photos.front().camera;
  input.first_id = first_id;
  input.points = &inputs.photos.points;
  input.start = CameraCenter(photos.back().cam_from_world);
  const Surface surface = ConfidentSurface(inputs, paths.mesh, path_options, job);
  const auto space =
      std::make_shared<const FreeSpace>(KnownSpace(surface, photos, *input.start, path_options));
  input.may_fly = FlyablePositions(space, path_options);
  input.may_reach = ReachablePositions(space, *input.start, path_options);
  input.limits = &path_options.limits;
  input.limits_margin_m = path_options.position_error_m;
  const ViewPlanResult plan = PlanNextViews(input, options, job);
  if (!plan.explanation.empty()) job.Warn("view_planner: " + plan.explanation);
  WriteViews(plan.views, inputs.frame, paths.output);
  job.Info(Describe(plan) + ": " + paths.output.string());
  program.log.Result({{"views", plan.views.size()},
                      {"reachable_uncovered", plan.reachable_uncovered},
                      {"stop_reason", plan.stop_reason},
                      {"output_path", paths.output.string()}});
  return 0;
}

}  // namespace colmap_ext
