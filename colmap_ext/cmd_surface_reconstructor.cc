#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct SurfaceReconstructorPaths {
  std::filesystem::path workspace, input, output;
};

void CheckPaths(const SurfaceReconstructorPaths& paths) {
  if (!paths.workspace.empty()) {
    if (!paths.input.empty() || !paths.output.empty()) {
      throw UsageError("give either --workspace_path, or --input_path and --output_path");
    }
    RequireFolder(paths.workspace, "workspace");
    return;
  }
  RequireOption(paths.input, "input_path");
  RequireOption(paths.output, "output_path");
}

RegionOfInterest RegionOfPoints(const OrientedPoints& points, const RegionOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!options.box.empty()) return {ParseBox(options.box)};
  RegionOfInterest region;
  if (!options.polygon_path.empty()) {
    throw UsageError("a cloud alone has no place on Earth: give --RegionOfInterest.box");
  }
  for (const OrientedPoint& point : points) {
    if (point.position.allFinite()) region.box.extend(point.position);
  }
  return region;
}

// Returns the numbers of the log's result.
ProgramLog::Json LogSurface(const Surface& surface, const std::filesystem::path& path,
                            const JobControl& job) {
  job.Info("surface: " + std::to_string(surface.mesh.vertices.size()) + " vertices, " +
           std::to_string(surface.mesh.faces.size()) + " faces: " + path.string());
  return {{"vertices", surface.mesh.vertices.size()},
          {"faces", surface.mesh.faces.size()},
          {"output_path", path.string()}};
}

ProgramLog::Json RunInWorkspace(const Workspace& workspace, const RegionOptions& region_options,
                                const SurfaceOptions& options, const JobControl& job) {
  const IterationFiles files = LatestIterationFiles(workspace);
  RequireFile(files.fused_ply(), "fused points (superpixel_stereo writes them)");
  const StageTimer timer;
  const OrientedPoints points = ReadOrientedPoints(files.fused_ply());
  const RegionOfInterest region = RegionOfWorkspace(workspace, region_options);
  const Surface surface = ReconstructSurface(points, region, options, job);
  WriteSurface(surface, files.surface_ply());
  RecordStageCost(files.timing_json(), "surface", timer.Stop());
  return LogSurface(surface, files.surface_ply(), job);
}

ProgramLog::Json RunOnFiles(const SurfaceReconstructorPaths& paths,
                            const RegionOptions& region_options, const SurfaceOptions& options,
                            const JobControl& job) {
  RequireFile(paths.input, "points");
  const OrientedPoints points = ReadOrientedPoints(paths.input);
  if (points.empty()) throw Error(paths.input.string() + ": the file has no points");
  const Surface surface =
      ReconstructSurface(points, RegionOfPoints(points, region_options), options, job);
  WriteSurface(surface, paths.output);
  return LogSurface(surface, paths.output, job);
}

}  // namespace

int RunSurfaceReconstructor(const Arguments& arguments, Program& program) {
  CommandLine line(
      "surface_reconstructor",
      "Screened Poisson surface of fused points, with the strength of their support "
      "(sample_spacing_m) at every vertex. --workspace_path: fused.ply of the newest "
      "iteration becomes its surface.ply. --input_path and --output_path: any PLY file "
      "of points with normals, for example COLMAP's fused.ply.");
  SurfaceReconstructorPaths paths;
  SurfaceOptions options;
  RegionOptions region_options;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "PLY file of points with normals");
  line.options().Add("", "output_path", &paths.output, "PLY file of the surface, to be written");
  BindOptions(line.options(), &options);
  BindOptions(line.options(), &region_options);
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckPaths(paths);

  const JobControl job = program.Job();
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    program.log.Result(RunInWorkspace(workspace, region_options, options, job));
  } else {
    program.log.Result(RunOnFiles(paths, region_options, options, job));
  }
  return 0;
}

}  // namespace colmap_ext
