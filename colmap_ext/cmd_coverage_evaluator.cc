#include <cstdio>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct Paths {
  std::filesystem::path workspace, input, mesh, output;
};

void CheckPaths(const Paths& paths) {
  RequireWorkspaceOrFiles(
      paths.workspace,
      {{"input_path", paths.input}, {"mesh_path", paths.mesh}, {"output_path", paths.output}});
}

// A mesh of unknown origin comes back without signal.
Surface ReadSurfaceOrMesh(const std::filesystem::path& path, const JobControl& job) {
  RequireFile(path, "mesh");
  const PlyData data = ReadPly(path);
  const PlyElement* vertices = data.FindElement("vertex");
  if (vertices != nullptr && vertices->FindScalar("sample_spacing_m") != nullptr) {
    return ReadSurface(path);
  }
  job.Info(path.string() + " has no sample_spacing_m: views alone decide, the signal is skipped");
  Surface surface;
  surface.mesh = ReadMesh(path);
  return surface;
}

void WriteResults(const CoverageMap& map, const CoverageOptions& options,
                  const std::filesystem::path& ply, const std::filesystem::path& json,
                  const JobControl& job) {
  WriteCoverageMap(map, ply);
  WriteCoverageSummary(map, ThresholdsOf(options), json);
  char text[160];
  std::snprintf(text, sizeof(text), "coverage: %.1f %% (%zu covered, %zu uncovered, %zu ignored)",
                100 * map.CoveredRatio(), map.Count(CoverageClass::kCovered),
                map.Count(CoverageClass::kUncovered), map.Count(CoverageClass::kIgnored));
  job.Info(std::string(text) + ": " + ply.string());
}

void RunInWorkspace(const Workspace& workspace, const RegionOptions& region_options,
                    const CoverageOptions& options, int max_width_px, const JobControl& job) {
  const IterationFiles files = LatestIterationFiles(workspace);
  RequireFile(files.surface_ply(), "surface (surface_reconstructor writes it)");
  const StageTimer timer;
  const Surface surface = ReadSurface(files.surface_ply());
  const PhotoSet photos = LoadPosesOnly(files.sparse(), max_width_px);
  const RegionOfInterest region = RegionOfWorkspace(workspace, region_options);
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, region, options, job);
  WriteResults(map, options, files.coverage_ply(), files.coverage_json(), job);
  RecordStageCost(files.timing_json(), "coverage", timer.Stop());
}

void RunOnFiles(const Paths& paths, const RegionOptions& region_options,
                const CoverageOptions& options, int max_width_px, const JobControl& job) {
  RequireFolder(paths.input, "sparse model");
  const Surface surface = ReadSurfaceOrMesh(paths.mesh, job);
  if (surface.mesh.faces.empty()) {
    throw Error(paths.mesh.string() +
                ": points without triangles; make a mesh of them with surface_reconstructor");
  }
  const PhotoSet photos = LoadPosesOnly(paths.input, max_width_px);
  const WorldFrame frame = FrameOrMetric(paths.input / ".." / "frame.json");
  const RegionOfInterest region = DefaultRegion(photos, frame, region_options);
  RequireWritableFolder(paths.output, "output folder");
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, region, options, job);
  WriteResults(map, options, paths.output / "coverage.ply", paths.output / "coverage.json", job);
}

}  // namespace

int RunCoverageEvaluator(const Arguments& arguments, const CancelFlag& cancel) {
  CommandLine line(
      "coverage_evaluator",
      "Tells where the photos suffice for a good model: covered, uncovered, or ignored "
      "outside the region of interest. --workspace_path: the newest iteration. "
      "--input_path, --mesh_path and --output_path: any COLMAP sparse model in metres, "
      "z up, with any PLY mesh of the scene; coverage.ply and coverage.json go to the "
      "output folder.");
  Paths paths;
  CoverageOptions options;
  RegionOptions region_options;
  int max_width_px = 0;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "folder of a sparse model");
  line.options().Add("", "mesh_path", &paths.mesh, "PLY file of a mesh");
  line.options().Add("", "output_path", &paths.output, "folder to write to");
  line.options().Add(
      "", "max_image_size_px", &max_width_px,
      "judge the photos as though scaled down to this width; 0: as the session does, "
      "or as they are");
  BindOptions(line.options(), &options);
  BindOptions(line.options(), &region_options);
  if (!line.Parse(arguments)) return 0;
  CheckPaths(paths);
  if (max_width_px < 0) throw UsageError("--max_image_size_px must not be negative");

  ConsoleSink sink(line.log_level());
  const JobControl job(&sink, &cancel);
  constexpr int kAsTheyAre = 1 << 30;
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    RunInWorkspace(workspace, region_options, options,
                   max_width_px > 0 ? max_width_px : SessionImageWidth(workspace), job);
  } else {
    RunOnFiles(paths, region_options, options, max_width_px > 0 ? max_width_px : kAsTheyAre, job);
  }
  return 0;
}

}  // namespace colmap_ext
