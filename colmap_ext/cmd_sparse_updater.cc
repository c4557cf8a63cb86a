#include <charconv>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "colmap_ext/scene/position_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/stage_timer.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct SparseUpdaterInputs {
  fs::path workspace_path;
  fs::path database_path, image_path, input_path, sparse_path, output_path;
  fs::path geo_path, pose_prior_path, colmap_path;
  std::string camera_model, camera_params;
  bool update_database = false;
};

// Where everything is, whichever way it was given.
struct Places {
  fs::path input_model, input_frame, input_state;  // empty: start a new model
  fs::path output_model, output_frame, output_state;
  fs::path timing;  // empty: not written
};

void BindInputs(OptionSet& set, SparseUpdaterInputs* inputs) {
  set.Add("", "workspace_path", &inputs->workspace_path,
          "workspace: its photos and database, its newest model; the result is a new iteration");
  set.Add("", "image_path", &inputs->image_path, "folder of the photos");
  set.Add(
      "", "database_path", &inputs->database_path,
      "COLMAP database; default: OUTPUT/database.db. One that exists elsewhere is copied there");
  set.Add("", "update_database", &inputs->update_database,
          "replace the database at database_path instead of copying it (0 or 1)");
  set.Add("", "input_path", &inputs->input_path, "sparse model to continue; it is only read");
  set.Add("", "sparse_path", &inputs->sparse_path, "the same as input_path");
  set.Add("", "output_path", &inputs->output_path, "new folder for the model");
  set.Add("", "geo_path", &inputs->geo_path, "positions of photos: lines of name lon lat alt");
  set.Add("", "pose_prior_path", &inputs->pose_prior_path,
          "positions of photos in local metres: lines of name x y z");
  set.Add("", "camera_params", &inputs->camera_params,
          "known intrinsics, then locked: f,cx,cy or f,cx,cy,k or as camera_model has them (px)");
  set.Add("", "camera_model", &inputs->camera_model,
          "COLMAP's name of the camera model; default: SIMPLE_PINHOLE or SIMPLE_RADIAL");
  set.Add("", "colmap_path", &inputs->colmap_path, "the colmap program; default: on the PATH");
}

std::vector<double> ParseNumbers(const std::string& text) {
  std::vector<double> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    double number = 0;
    const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, number);
    if (error != std::errc() || stop != text.data() + end) {
      throw UsageError("--camera_params: \"" + text +
                       "\" is not a list of numbers like 500,320,240");
    }
    numbers.push_back(number);
    begin = end + 1;
  }
  return numbers;
}

std::optional<Camera> ParseCamera(const SparseUpdaterInputs& inputs) {
  if (inputs.camera_params.empty()) {
    if (inputs.camera_model.empty()) return std::nullopt;
    throw UsageError("--camera_model needs --camera_params");
  }
  Camera camera;
  camera.params = ParseNumbers(inputs.camera_params);
  std::string model = inputs.camera_model;
  if (model.empty()) model = camera.params.size() == 3 ? "SIMPLE_PINHOLE" : "SIMPLE_RADIAL";
  try {
    const CameraModelInfo& info = GetCameraModelInfo(model);
    camera.model = info.model;
    if (static_cast<int>(camera.params.size()) != info.num_params) {
      throw UsageError("--camera_params: " + model + " has " + std::to_string(info.num_params) +
                       " parameters, " + std::to_string(camera.params.size()) + " are given");
    }
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    throw UsageError("--camera_model: " + std::string(error.what()));
  }
  if (!(camera.params[0] > 0))
    throw UsageError("--camera_params: the focal length must be above 0");
  return camera;
}

Places PlacesInWorkspace(const Workspace& workspace) {
  Places places;
  int next = 0;
  if (const std::optional<int> latest = workspace.LatestIteration()) {
    const IterationFiles files{workspace.iteration(*latest)};
    places.input_model = files.sparse();
    places.input_frame = files.frame_json();
    places.input_state = files.sparse_state_json();
    next = *latest + 1;
  }
  const IterationFiles files{workspace.iteration(next)};
  places.output_model = files.sparse();
  places.output_frame = files.frame_json();
  places.output_state = files.sparse_state_json();
  places.timing = files.timing_json();
  return places;
}

Places PlacesFromPaths(const SparseUpdaterInputs& inputs) {
  Places places;
  if (!inputs.input_path.empty()) {
    places.input_model = inputs.input_path;
    places.input_frame = inputs.input_path / "frame.json";
    places.input_state = inputs.input_path / "sparse_state.json";
  }
  places.output_model = inputs.output_path;
  places.output_frame = inputs.output_path / "frame.json";
  places.output_state = inputs.output_path / "sparse_state.json";
  for (const char* name : {"images.bin", "images.txt"}) {
    if (!fs::exists(inputs.output_path / name)) continue;
    throw Error(inputs.output_path.string() +
                ": there is a model in this folder already; give a new one as --output_path");
  }
  return places;
}

// The database is updated in place only when told to, or when it is the output's own.
void SetDatabase(const SparseUpdaterInputs& inputs, SparseUpdateInput* input) {
  const fs::path own = inputs.output_path / "database.db";
  input->database_path = own;
  if (inputs.database_path.empty()) return;
  const bool is_own = fs::weakly_canonical(inputs.database_path) == fs::weakly_canonical(own);
  const bool is_new = !fs::exists(inputs.database_path) && inputs.input_path.empty();
  if (is_own || is_new || inputs.update_database) {
    input->database_path = inputs.database_path;
    return;
  }
  RequireFile(inputs.database_path, "database");
  if (fs::exists(own)) {
    throw Error(own.string() +
                ": a database is there already; give it as --database_path to go on "
                "with it, or a new --output_path");
  }
  input->base_database_path = inputs.database_path;
}

// One name for the model.
void JoinNames(SparseUpdaterInputs* inputs) {
  if (inputs->sparse_path.empty()) return;
  if (!inputs->input_path.empty()) throw UsageError("give --sparse_path or --input_path, not both");
  inputs->input_path = inputs->sparse_path;
}

void CheckPaths(const SparseUpdaterInputs& inputs) {
  if (!inputs.workspace_path.empty()) {
    if (!inputs.input_path.empty() || !inputs.output_path.empty() ||
        !inputs.database_path.empty()) {
      throw UsageError(
          "give either --workspace_path, or --image_path and --output_path with "
          "--database_path and --input_path");
    }
    return;
  }
  RequireOption(inputs.image_path, "image_path");
  RequireOption(inputs.output_path, "output_path");
  if (!inputs.input_path.empty()) RequireOption(inputs.database_path, "database_path");
}

SparseUpdateInput UpdateInputFor(const SparseUpdaterInputs& inputs) {
  SparseUpdateInput input;
  const Workspace workspace(inputs.workspace_path);
  const bool in_workspace = !inputs.workspace_path.empty();
  input.colmap_path = inputs.colmap_path;
  input.image_path = inputs.image_path.empty() ? workspace.images() : inputs.image_path;
  input.camera = ParseCamera(inputs);
  if (!inputs.geo_path.empty()) input.geo_position_of_photo = ReadGeoFile(inputs.geo_path);
  if (!inputs.pose_prior_path.empty()) {
    input.local_position_of_photo = ReadPosePriorFile(inputs.pose_prior_path);
  }
  RequireFolder(input.image_path, "image folder");
  if (in_workspace) RequireFolder(inputs.workspace_path, "workspace");
  if (in_workspace) {
    input.database_path = workspace.database();
    input.work_path = workspace.logs() / "sparse";
  } else {
    SetDatabase(inputs, &input);
    input.work_path = inputs.output_path / "logs";
  }
  return input;
}

void PrintSummary(const SparseUpdateResult& result, const Places& places) {
  const std::size_t total = result.registered.size() + result.unregistered.size();
  std::printf("%zu of %zu photos registered, %zu of them new; %zu points, %.3f px mean error\n",
              result.registered.size(), total, result.newly_registered.size(),
              result.model.points.size(), result.mean_error_px);
  for (const std::vector<std::string>& names : result.other_models) {
    std::printf("a model of its own, not joined yet: %zu photos from %s to %s\n", names.size(),
                names.front().c_str(), names.back().c_str());
  }
  if (const auto& fit = result.adjustment_of_all) {
    std::printf("all poses adjusted: %zu observations, %.3f px RMS before, %.3f px after\n",
                fit->num_observations, fit->initial_rms_px, fit->final_rms_px);
  }
  if (const auto& fit = result.georegistration; fit && fit->world_from_model) {
    std::printf("georegistered: %d positions, residual %.2f m RMS, %.2f m at most, %zu outliers\n",
                fit->num_used, fit->rms_m, fit->max_m, fit->outliers.size());
  }
  for (const auto& [step, cost] : result.cost_of_step) {
    std::printf("  %-16s %7.2f s  (CPU %.2f s)\n", step.c_str(), cost.wall_s, cost.cpu_s);
  }
  std::printf("model: %s\n", places.output_model.c_str());
}

void WriteResult(const SparseUpdateResult& result, const Places& places) {
  WriteWorldFrame(result.frame, places.output_frame);
  WriteSparseState(result.state, places.output_state);
  WriteReconstructionBinary(result.model, places.output_model);
  WriteGeoregistration(result, places.output_model);
}

}  // namespace

int RunSparseUpdater(const Arguments& arguments, Program& program) {
  CommandLine line(
      "sparse_updater",
      "Photos to a sparse model in local metres (ENU), or more photos into a model that is "
      "there, with the colmap program. Only new photos cost time, and the old poses keep "
      "their place. An existing COLMAP project is given by --database_path, --image_path "
      "and --sparse_path; nothing of it is changed: the new model and the updated copy of "
      "the database go to --output_path (or, with --update_database 1, the database is "
      "replaced in one step where it is).");
  SparseUpdaterInputs inputs;
  SparseUpdateOptions options;
  BindInputs(line.options(), &inputs);
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  JoinNames(&inputs);
  CheckPaths(inputs);
  ThrowIfInvalid(options.Check());
  const JobControl job = program.Job();

  const StageTimer timer;
  const Places places = inputs.workspace_path.empty()
                            ? PlacesFromPaths(inputs)
                            : PlacesInWorkspace(Workspace(inputs.workspace_path));
  SparseUpdateInput input = UpdateInputFor(inputs);
  Reconstruction earlier;
  if (!places.input_model.empty()) {
    earlier = ReadReconstruction(places.input_model);
    input.model = &earlier;
    if (fs::exists(places.input_frame)) input.frame = ReadWorldFrame(places.input_frame);
    input.state = ReadSparseState(places.input_state);
  }
  const SparseUpdateResult result = UpdateSparseModel(input, options, job);
  if (!result.changed) {
    std::printf("nothing new: every photo is in the model or was tried (%s)\n",
                places.input_model.c_str());
    program.log.Result({{"changed", false}, {"model", places.input_model.string()}});
    return 0;
  }
  WriteResult(result, places);
  if (!places.timing.empty()) {
    WriteFileAtomically(places.timing, StageCostsToJson({{"sparse", timer.Stop()}}));
  }
  PrintSummary(result, places);
  program.log.Result({{"changed", true},
                      {"photos", result.registered.size() + result.unregistered.size()},
                      {"registered", result.registered.size()},
                      {"newly_registered", result.newly_registered.size()},
                      {"unregistered", result.unregistered},
                      {"points", result.model.points.size()},
                      {"mean_error_px", result.mean_error_px},
                      {"model", places.output_model.string()}});
  return 0;
}

}  // namespace colmap_ext
