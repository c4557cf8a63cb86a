#include <cctype>
#include <iostream>
#include <optional>

#include "colmap_ext/eval/count_views.h"
#include "colmap_ext/eval/error_colors.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/report/error_histogram.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/las.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"
#include "command_line.h"
#include "commands.h"
#include "depth_evaluation.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct ModelEvaluatorPaths {
  fs::path workspace;
  fs::path mesh;
  fs::path depth;
  fs::path confidence;
  fs::path ground_truth;
  fs::path input;
  fs::path camera;
  fs::path output;
  fs::path error_mesh;
  fs::path error_cloud;
  fs::path histogram;
};

void AddPaths(OptionSet& set, ModelEvaluatorPaths* paths) {
  set.Add("", "workspace_path", &paths->workspace,
          "a session: its last surface, sparse model and output folder, unless given below");
  set.Add("", "mesh_path", &paths->mesh,
          "the model: a PLY mesh or cloud, or a COLMAP dense workspace (its meshed or fused PLY)");
  set.Add("", "ground_truth_path", &paths->ground_truth,
          "the truth in metres: a PLY mesh or cloud, or a LAS scan; with --depth_path the true "
          "depth maps");
  set.Add("", "input_path", &paths->input,
          "sparse model whose cameras belong to the mesh; with it, what the photos cannot see is "
          "reported apart");
  set.Add("", "camera_path", &paths->camera,
          "true poses, lines of: name qw qx qy qz tx ty tz (cam_from_world); with a sparse model "
          "the cameras give the first alignment");
  set.Add("", "depth_path", &paths->depth,
          "depth maps to judge instead of a mesh: a map, or a folder of maps (COLMAP's .bin)");
  set.Add("", "confidence_path", &paths->confidence,
          "confidence maps of the same names; errors are then given by confidence, too");
  set.Add("", "output_path", &paths->output, "JSON file to write");
  set.Add("", "error_mesh_path", &paths->error_mesh,
          "PLY to write: the aligned model, each vertex coloured by its distance to the truth");
  set.Add("", "error_cloud_path", &paths->error_cloud,
          "PLY to write: samples of the truth, coloured by their distance to the model");
  set.Add("", "histogram_path", &paths->histogram, "picture to write (PNG): histogram of errors");
}

void FillFromWorkspace(ModelEvaluatorPaths* paths) {
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

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// The best model of a COLMAP dense workspace.
fs::path ModelOfDenseWorkspace(const fs::path& folder) {
  for (const char* name : {"meshed-poisson.ply", "meshed-delaunay.ply", "fused.ply"}) {
    if (fs::is_regular_file(folder / name)) return folder / name;
  }
  throw Error(folder.string() +
              ": no meshed-poisson.ply, meshed-delaunay.ply or fused.ply; run `colmap "
              "stereo_fusion` there, or name the mesh");
}

TriangleMesh ReadModel(const fs::path& path, const std::string& what) {
  if (fs::is_directory(path)) return ReadMesh(ModelOfDenseWorkspace(path));
  RequireFile(path, what);
  const std::string extension = LowerExtension(path);
  if (extension == ".las" || extension == ".laz") return {ReadLasPoints(path), {}};
  if (extension != ".ply") {
    throw Error(path.string() + ": the " + what +
                " must be a PLY or LAS file; convert it first (MeshLab, CloudCompare or `assimp "
                "export` do it)");
  }
  return ReadMesh(path);
}

// The sparse model of --input_path, when there is one.
std::optional<Reconstruction> ReadSparseModel(const ModelEvaluatorPaths& paths) {
  if (paths.input.empty()) return std::nullopt;
  return ReadReconstruction(paths.input);
}

std::vector<CameraPair> ReadCameraPairs(const ModelEvaluatorPaths& paths,
                                        const std::optional<Reconstruction>& sparse) {
  if (paths.camera.empty()) return {};
  RequireOption(paths.input, "input_path");
  RequireFile(paths.camera, "file of true poses");
  const auto pairs = PairCameras(*sparse, PoseOfPhoto(ReadTruePoses(paths.camera)));
  if (pairs.empty()) {
    throw Error(paths.camera.string() + ": no photo has the name of one in " +
                paths.input.string());
  }
  return pairs;
}

void PrintResult(const EvaluationResult& result, const ModelAlignment& alignment) {
  std::cout << "mean error       " << FormatNumber("%8.1f mm", 1000 * result.errors.mean_m)
            << "\nRMS error        " << FormatNumber("%8.1f mm", 1000 * result.errors.rms_m)
            << "\nmedian error     " << FormatNumber("%8.1f mm", 1000 * result.errors.median_m)
            << "\n90th percentile  "
            << FormatNumber("%8.1f mm", 1000 * result.errors.percentile90_m)
            << "\nscale            " << FormatNumber("%12.6f", alignment.truth_from_model.scale)
            << "\nsamples          "
            << FormatNumber("%8.0f", static_cast<double>(result.truth_samples.size()))
            << "\n\n  distance  completeness  accuracy   F-score\n";
  for (const ThresholdScore& score : result.scores) {
    std::cout << FormatNumber("%7.1f mm", 1000 * score.threshold_m)
              << FormatNumber("%12.1f %%", 100 * score.completeness)
              << FormatNumber("%8.1f %%", 100 * score.accuracy)
              << FormatNumber("%8.1f %%\n", 100 * score.f_score);
  }
}

void PrintPart(const char* title, const ErrorSummary& part, const EvaluationResult& result) {
  std::cout << '\n'
            << title
            << FormatNumber(": %.1f %% of the truth",
                            100 * static_cast<double>(part.samples) /
                                static_cast<double>(result.truth_samples.size()));
  if (part.samples > 0) {
    std::cout << FormatNumber(", mean error %.1f mm", 1000 * part.mean_m)
              << FormatNumber(", RMS %.1f mm", 1000 * part.rms_m);
    for (std::size_t i = 0; i < result.scores.size(); ++i) {
      std::cout << FormatNumber(", within %.1f mm", 1000 * result.scores[i].threshold_m)
                << FormatNumber(" %.1f %%", 100 * part.completeness[i]);
    }
  }
  std::cout << '\n';
}

// Splits the result by what the photos can see, where that can be told.
void CountSeen(const std::optional<Reconstruction>& sparse, const TriangleMesh& truth,
               const ModelAlignment& alignment, const EvaluationOptions& options,
               const JobControl& job, EvaluationResult* result) {
  if (!sparse) return;
  if (truth.faces.empty()) {
    job.Info("the truth is a cloud: what the photos cannot see is not told apart");
    return;
  }
  SplitBySeen(CountViews(result->truth_samples, truth, *sparse, alignment.truth_from_model, job),
              options, result);
}

void WritePictures(const TriangleMesh& aligned, const TriangleMesh& truth,
                   const EvaluationResult& result, const EvaluationOptions& options,
                   const ModelEvaluatorPaths& paths) {
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
  if (!paths.histogram.empty()) {
    WritePng(
        DrawErrorHistogram(result.truth_error_m, max_error_m, options.ThresholdsM(), {1000, 480}),
        paths.histogram);
  }
}

void EvaluateMesh(const ModelEvaluatorPaths& paths, const EvaluationOptions& options,
                  const JobControl& job) {
  const TriangleMesh model = ReadModel(paths.mesh, "mesh");
  const TriangleMesh truth = ReadModel(paths.ground_truth, "ground truth");
  const std::optional<Reconstruction> sparse = ReadSparseModel(paths);
  const ModelAlignment alignment =
      AlignModel(model, truth, ReadCameraPairs(paths, sparse), options, job);
  if (alignment.cameras) {
    for (const std::string& name : alignment.cameras->rejected) {
      job.Warn(name + ": its pose contradicts the other photos; it was left out of the alignment");
    }
  }
  const TriangleMesh aligned = TransformMesh(alignment.truth_from_model, model);
  EvaluationResult result = EvaluateModel(aligned, truth, options, job);
  CountSeen(sparse, truth, alignment, options, job, &result);
  WriteFileAtomically(paths.output, EvaluationToJson(result, alignment, options));
  WritePictures(aligned, truth, result, options, paths);
  PrintResult(result, alignment);
  if (result.seen) {
    PrintPart(options.min_views == 1 ? "seen by a photo" : "seen by enough photos", *result.seen,
              result);
  }
  if (result.unseen) PrintPart("not seen", *result.unseen, result);
}

}  // namespace

int RunModelEvaluator(const Arguments& arguments, Program& program) {
  ModelEvaluatorPaths paths;
  EvaluationOptions options;
  CommandLine line("model_evaluator",
                   "Aligns a mesh or cloud to its ground truth (by cameras when their true poses "
                   "are given, then by ICP with scale; --ModelEvaluator.icp_iterations 0 leaves it "
                   "where it is) and measures error, completeness, accuracy and F-score. With "
                   "--depth_path: measures depth maps against true ones.");
  AddPaths(line.options(), &paths);
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  const bool judges_depth = !paths.depth.empty();
  if (!judges_depth) FillFromWorkspace(&paths);
  if (!judges_depth) RequireOption(paths.mesh, "mesh_path");
  RequireOption(paths.ground_truth, "ground_truth_path");
  RequireOption(paths.output, "output_path");
  ThrowIfInvalid(options.Check());
  const JobControl job = program.Job();
  if (judges_depth) {
    EvaluateDepthMaps({paths.depth, paths.ground_truth, paths.confidence}, paths.output, job);
  } else {
    EvaluateMesh(paths, options, job);
  }
  job.Info("wrote " + paths.output.string());
  program.log.Result(ReadJsonFile(paths.output));
  return 0;
}

}  // namespace colmap_ext
