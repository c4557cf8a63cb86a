#include <cstdio>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/coverage/ortho_map.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/surface/point_normals.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

struct CoverageEvaluatorPaths {
  std::filesystem::path workspace, input, mesh, output;
};

void CheckPaths(const CoverageEvaluatorPaths& paths) {
  RequireWorkspaceOrFiles(
      paths.workspace,
      {{"input_path", paths.input}, {"mesh_path", paths.mesh}, {"output_path", paths.output}});
}

struct Options {
  CoverageOptions coverage;
  RegionOptions region;
  SurfaceOptions surface;  // for a cloud
  OrthoMapOptions ortho_map;
  int max_width_px = 0;
};

// Points of another program, with normals or without.
OrientedPoints ReadCloud(const std::filesystem::path& path, const PhotoSet& photos,
                         const JobControl& job) {
  constexpr int kNeighborsOfNormal = 16;
  const PlyData data = ReadPly(path);
  const PlyElement* vertices = data.FindElement("vertex");
  if (vertices != nullptr && vertices->FindScalar("nx") != nullptr) return ReadOrientedPoints(path);
  job.Info(path.string() + " has no normals: they are estimated, towards the photos");
  OrientedPoints points;
  for (const Eigen::Vector3d& position : ReadMesh(path).vertices) {
    points.emplace_back().position = position;
  }
  EstimateNormals(photos.photos, kNeighborsOfNormal, &points);
  return points;
}

// A mesh of unknown origin comes back without signal, a cloud as its surface with it.
Surface ReadSurfaceMeshOrCloud(const std::filesystem::path& path, const PhotoSet& photos,
                               const RegionOfInterest& region, const Options& options,
                               const JobControl& job) {
  RequireFile(path, "mesh");
  const PlyData data = ReadPly(path);
  const PlyElement* vertices = data.FindElement("vertex");
  if (vertices != nullptr && vertices->FindScalar("sample_spacing_m") != nullptr) {
    return ReadSurface(path);
  }
  Surface surface;
  surface.mesh = ReadMesh(path);
  if (surface.mesh.faces.empty()) {
    job.Info(path.string() + " holds points without triangles: their Poisson surface is judged");
    return ReconstructSurface(ReadCloud(path, photos, job), region, options.surface, job);
  }
  job.Info(path.string() + " has no sample_spacing_m: views alone decide, the signal is skipped");
  return surface;
}

struct OutputFiles {
  std::filesystem::path ply, json, map;
};

// Returns the numbers of the log's result.
ProgramLog::Json WriteResults(const Surface& surface, const CoverageMap& map,
                              const RegionOfInterest& region, const WorldFrame& frame,
                              const Options& options, const OutputFiles& files,
                              const JobControl& job) {
  WriteCoverageMap(map, files.ply);
  WriteCoverageSummary(map, ThresholdsOf(options.coverage), files.json);
  if (frame.is_metric_enu) {
    WriteOrthoMap(RenderOrthoMap(surface, map, region, options.ortho_map), frame, files.map);
  }
  char text[160];
  std::snprintf(text, sizeof(text), "coverage: %.1f %% (%zu covered, %zu uncovered, %zu ignored)",
                100 * map.CoveredRatio(), map.Count(CoverageClass::kCovered),
                map.Count(CoverageClass::kUncovered), map.Count(CoverageClass::kIgnored));
  job.Info(std::string(text) + ": " + files.ply.string());
  if (map.Count(CoverageClass::kCovered) + map.Count(CoverageClass::kUncovered) == 0) {
    job.Warn("nothing of the surface lies in the region of interest: nothing was judged");
  }
  return {{"covered_ratio", map.CoveredRatio()},
          {"covered", map.Count(CoverageClass::kCovered)},
          {"uncovered", map.Count(CoverageClass::kUncovered)},
          {"ignored", map.Count(CoverageClass::kIgnored)},
          {"output_path", files.ply.parent_path().string()}};
}

ProgramLog::Json RunInWorkspace(const Workspace& workspace, const Options& options,
                                const JobControl& job) {
  const IterationFiles files = LatestIterationFiles(workspace);
  RequireFile(files.surface_ply(), "surface (surface_reconstructor writes it)");
  const StageTimer timer;
  const Surface surface = ReadSurface(files.surface_ply());
  const PhotoSet photos = LoadPosesOnly(files.sparse(), options.max_width_px);
  const RegionOfInterest region = RegionOfWorkspace(workspace, options.region);
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, region, options.coverage, job);
  const StageCost cost = timer.Stop();
  RecordStageCost(files.timing_json(), "coverage", cost);
  return WriteResults(
      surface, map, region, FrameOrMetric(files.frame_json()), options,
      {files.coverage_ply(), files.coverage_json(), files.folder / "coverage_map.png"}, job);
}

ProgramLog::Json RunOnFiles(const CoverageEvaluatorPaths& paths, const Options& options,
                            const JobControl& job) {
  RequireFolder(paths.input, "sparse model");
  const PhotoSet photos = LoadPosesOnly(paths.input, options.max_width_px);
  const WorldFrame frame = FrameOfModel(paths.input);
  const RegionOfInterest region = DefaultRegion(photos, frame, options.region);
  const Surface surface = ReadSurfaceMeshOrCloud(paths.mesh, photos, region, options, job);
  RequireWritableFolder(paths.output, "output folder");
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, region, options.coverage, job);
  return WriteResults(surface, map, region, frame, options,
                      {paths.output / "coverage.ply", paths.output / "coverage.json",
                       paths.output / "coverage_map.png"},
                      job);
}

}  // namespace

int RunCoverageEvaluator(const Arguments& arguments, Program& program) {
  CommandLine line(
      "coverage_evaluator",
      "Tells where the photos suffice for a good model: covered, uncovered, or ignored "
      "outside the region of interest. --workspace_path: the newest iteration. "
      "--input_path, --mesh_path and --output_path: any COLMAP sparse model in metres, "
      "z up, with any PLY mesh or point cloud of the scene (a fast or a dense one); "
      "coverage.ply, coverage.json and coverage_map.png, the map from above with its world file, "
      "go to the output folder.");
  CoverageEvaluatorPaths paths;
  Options options;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "folder of a sparse model");
  line.options().Add("", "mesh_path", &paths.mesh, "PLY file of a mesh or of points");
  line.options().Add("", "output_path", &paths.output, "folder to write to");
  line.options().Add(
      "", "max_image_size_px", &options.max_width_px,
      "judge the photos as though scaled down to this width; 0: as the session does, "
      "or as they are");
  BindOptions(line.options(), &options.coverage);
  BindOptions(line.options(), &options.region);
  BindOptions(line.options(), &options.surface);
  BindOptions(line.options(), &options.ortho_map);
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckPaths(paths);
  if (options.max_width_px < 0) throw UsageError("--max_image_size_px must not be negative");

  const JobControl job = program.Job();
  constexpr int kAsTheyAre = 1 << 30;
  if (!paths.workspace.empty()) {
    const Workspace workspace(paths.workspace);
    TakeSessionOptions(workspace, &line.options());
    if (options.max_width_px == 0) options.max_width_px = SessionImageWidth(workspace);
    program.log.Result(RunInWorkspace(workspace, options, job));
  } else {
    if (options.max_width_px == 0) options.max_width_px = kAsTheyAre;
    program.log.Result(RunOnFiles(paths, options, job));
  }
  return 0;
}

}  // namespace colmap_ext
