#include <cstdio>
#include <iostream>

#include "colmap_ext/eval/camera_poses.h"
#include "colmap_ext/eval/error_colors.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct Paths {
  fs::path workspace;
  fs::path mesh;
  fs::path ground_truth;
  fs::path input;
  fs::path camera;
  fs::path output;
  fs::path error_mesh;
  fs::path error_cloud;
};

void AddPaths(OptionSet& set, Paths* paths) {
  set.Add("", "workspace_path", &paths->workspace,
          "a session: its last surface, sparse model and output folder, unless given below");
  set.Add("", "mesh_path", &paths->mesh, "the model, a PLY mesh or cloud");
  set.Add("", "ground_truth_path", &paths->ground_truth, "the truth, a PLY mesh in metres");
  set.Add("", "input_path", &paths->input, "sparse model whose cameras belong to the mesh");
  set.Add("", "camera_path", &paths->camera,
          "true poses, lines of: name qw qx qy qz tx ty tz (cam_from_world); with a sparse model "
          "the cameras give the first alignment");
  set.Add("", "output_path", &paths->output, "JSON file to write");
  set.Add("", "error_mesh_path", &paths->error_mesh,
          "PLY to write: the aligned model, each vertex coloured by its distance to the truth");
  set.Add("", "error_cloud_path", &paths->error_cloud,
          "PLY to write: samples of the truth, coloured by their distance to the model");
}

void FillFromWorkspace(Paths* paths) {
  if (paths->workspace.empty()) return;
  RequireFolder(paths->workspace, "workspace");
  const Workspace workspace(paths->workspace);
  const auto latest = workspace.LatestIteration();
  if (!latest) throw Error(paths->workspace.string() + ": no iteration has a model yet");
  const IterationFiles files{workspace.iteration(*latest)};
  if (paths->mesh.empty()) paths->mesh = files.surface_ply();
  if (paths->input.empty()) paths->input = files.sparse();
  if (paths->output.empty()) paths->output = files.folder / "evaluation.json";
}

TriangleMesh ReadPlyMesh(const fs::path& path, const std::string& what) {
  RequireFile(path, what);
  if (path.extension() != ".ply" && path.extension() != ".PLY") {
    throw Error(path.string() + ": the " + what +
                " must be a PLY file; convert it first (MeshLab, " +
                "CloudCompare or `assimp export` do it)");
  }
  return ReadMesh(path);
}

std::vector<CameraPair> ReadCameraPairs(const Paths& paths) {
  if (paths.camera.empty()) return {};
  RequireOption(paths.input, "input_path");
  RequireFile(paths.camera, "file of true poses");
  const auto pairs = PairCameras(ReadReconstruction(paths.input), ReadCameraPoses(paths.camera));
  if (pairs.empty()) {
    throw Error(paths.camera.string() + ": no photo has the name of one in " +
                paths.input.string());
  }
  return pairs;
}

std::string Format(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

void PrintResult(const EvaluationResult& result, const ModelAlignment& alignment) {
  std::cout << "mean error       " << Format("%8.1f mm", 1000 * result.errors.mean_m)
            << "\nRMS error        " << Format("%8.1f mm", 1000 * result.errors.rms_m)
            << "\nmedian error     " << Format("%8.1f mm", 1000 * result.errors.median_m)
            << "\nscale            " << Format("%12.6f", alignment.truth_from_model.scale)
            << "\nsamples          "
            << Format("%8.0f", static_cast<double>(result.truth_samples.size()))
            << "\n\n  distance  completeness  accuracy   F-score\n";
  for (const ThresholdScore& score : result.scores) {
    std::cout << Format("%7.1f mm", 1000 * score.threshold_m)
              << Format("%12.1f %%", 100 * score.completeness)
              << Format("%8.1f %%", 100 * score.accuracy)
              << Format("%8.1f %%\n", 100 * score.f_score);
  }
}

void WriteErrorPictures(const TriangleMesh& aligned, const TriangleMesh& truth,
                        const EvaluationResult& result, const EvaluationOptions& options,
                        const Paths& paths) {
  const double max_error_m = 2 * options.ThresholdsM().back();
  if (!paths.error_mesh.empty()) {
    WriteMesh(aligned, ErrorColors(DistancesTo(truth, aligned.vertices), max_error_m),
              paths.error_mesh);
  }
  if (!paths.error_cloud.empty()) {
    TriangleMesh cloud;
    for (const SurfaceSample& sample : result.truth_samples) {
      cloud.vertices.push_back(sample.position);
    }
    WriteMesh(cloud, ErrorColors(result.truth_error_m, max_error_m), paths.error_cloud);
  }
}

}  // namespace

int RunModelEvaluator(const Arguments& arguments, const CancelFlag& cancel) {
  Paths paths;
  EvaluationOptions options;
  CommandLine line("model_evaluator",
                   "Aligns a mesh or cloud to its ground truth (by cameras when their true poses "
                   "are given, then by ICP with scale) and measures error, completeness, accuracy "
                   "and F-score.");
  AddPaths(line.options(), &paths);
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments)) return 0;
  FillFromWorkspace(&paths);
  RequireOption(paths.mesh, "mesh_path");
  RequireOption(paths.ground_truth, "ground_truth_path");
  RequireOption(paths.output, "output_path");
  ThrowIfInvalid(options.Check());
  ConsoleSink sink(line.log_level());
  const JobControl job(&sink, &cancel);

  const TriangleMesh model = ReadPlyMesh(paths.mesh, "mesh");
  const TriangleMesh truth = ReadPlyMesh(paths.ground_truth, "ground truth");
  const ModelAlignment alignment = AlignModel(model, truth, ReadCameraPairs(paths), options, job);
  if (alignment.cameras) {
    for (const std::string& name : alignment.cameras->rejected) {
      job.Warn(name + ": its pose contradicts the other photos; it was left out of the alignment");
    }
  }
  const TriangleMesh aligned = TransformMesh(alignment.truth_from_model, model);
  const EvaluationResult result = EvaluateModel(aligned, truth, options, job);
  WriteFileAtomically(paths.output, EvaluationToJson(result, alignment, options));
  WriteErrorPictures(aligned, truth, result, options, paths);
  PrintResult(result, alignment);
  job.Info("wrote " + paths.output.string());
  return 0;
}

}  // namespace colmap_ext
