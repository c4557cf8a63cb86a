#include "colmap_ext/session/session.h"

#include <algorithm>
#include <memory>

#include "colmap_ext/report/session_page.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/position_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/sfm/feature_extraction.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/stage_timer.h"
#include "session/flown_capture.h"
#include "session/iteration.h"
#include "session/session_state.h"
#include "session/simulated_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// One line that says where the photos come from; a workspace keeps to it.
std::string SourceOf(const SessionInputs& inputs) {
  if (!inputs.scene.empty()) return "scene " + inputs.scene;
  if (!inputs.scene_path.empty()) return "scene file " + fs::absolute(inputs.scene_path).string();
  return "photos " + fs::absolute(inputs.image_path).lexically_normal().string();
}

struct Session {
  SessionInputs inputs;
  StageOptions options;
  Workspace workspace;
  SessionState state;
  SessionSummary summary;
};

Session OpenSession(const SessionInputs& inputs, const StageOptions& options) {
  Session session{inputs, options, Workspace(inputs.workspace_path), {}, {}};
  RequireWritableFolder(inputs.workspace_path, "workspace");
  const std::string source = SourceOf(inputs);
  if (fs::exists(session.workspace.state_json())) {
    session.state = ReadSessionState(session.workspace.state_json());
    if (session.state.source != source) {
      throw UsageError(inputs.workspace_path.string() + ": this workspace is of '" +
                       session.state.source + "', not of '" + source +
                       "'; choose another --workspace_path");
    }
    session.summary = ReadSummary(session.workspace.summary_json());
    // A session that was killed between the two files left one entry too many.
    const auto done = static_cast<std::size_t>(session.state.iterations_done);
    if (session.summary.iterations.size() < done) {
      throw Error(session.workspace.summary_json().string() + ": lacks iterations that " +
                  session.workspace.state_json().string() + " says are done");
    }
    session.summary.iterations.resize(done);
  }
  session.state.source = source;
  return session;
}

// A session that ended by a limit or at its target goes on when that was raised since.
bool IsFinished(const Session& session) {
  const std::string& finished = session.state.finished;
  const SessionOptions& limits = session.options.session;
  if (finished == "iteration_limit") return session.state.iterations_done >= limits.max_iterations;
  if (finished == "view_limit") {
    const IterationSummary& last = session.summary.iterations.back();
    return last.photos + last.planned_views > limits.max_photos;
  }
  if (finished == "covered") {
    const IterationSummary& last = session.summary.iterations.back();
    return last.planned_views == 0 ||
           last.reachable_covered_ratio.value_or(1.0) >= limits.target_covered_ratio;
  }
  return !finished.empty();
}

// Why the session ends after the last iteration; empty when it goes on.
std::string ReasonToFinish(const Session& session, const std::string& stop_reason) {
  if (!stop_reason.empty()) return stop_reason;
  const SessionOptions& limits = session.options.session;
  if (session.state.iterations_done >= limits.max_iterations) return "iteration_limit";
  const IterationSummary& last = session.summary.iterations.back();
  if (last.photos + last.planned_views > limits.max_photos) {
    return "view_limit";
  }
  return "";
}

// The results of an iteration count from the moment the state is replaced: until then a killed
// session repeats it.
void FinishIteration(const IterationResult& result, Session* session, const JobControl& job) {
  session->summary.iterations.push_back(result.summary);
  ++session->state.iterations_done;
  session->state.finished = ReasonToFinish(*session, result.stop_reason);
  session->summary.finished = session->state.finished;
  WriteSummary(session->summary, session->workspace.summary_json());
  WriteSessionState(session->state, session->workspace.state_json());
  WriteSessionPage(session->workspace, session->workspace.report(), session->inputs.image_path,
                   session->options.page, job);
}

void RemoveUnfinishedIteration(const Session& session) {
  std::error_code error;
  fs::remove_all(session.workspace.iteration(session.state.iterations_done), error);
  if (error) {
    throw Error(session.workspace.iteration(session.state.iterations_done).string() +
                ": cannot remove what an interrupted run left: " + error.message());
  }
}

void AnnounceIteration(const Session& session, const JobControl& job) {
  job.Info("Iteration " + std::to_string(session.state.iterations_done + 1));
}

void AnnounceResult(const IterationResult& result, const JobControl& job) {
  const IterationSummary& summary = result.summary;
  char line[160];
  std::snprintf(line, sizeof line,
                "  %d of %d photos registered, %.1f %% covered, %d views planned",
                summary.registered, summary.photos, 100.0 * summary.covered_ratio.value_or(0.0),
                summary.planned_views);
  job.Info(line);
}

// The path to fly in the present iteration. Later ones are read back from disk, so that a session
// that was stopped sees the same numbers as one that ran through.
std::vector<Waypoint> NextFlight(const SimulatedSite& site, Session* session) {
  if (session->state.iterations_done == 0) {
    const std::vector<PlannedView> views =
        InitialRectangle(site.Surroundings(), session->options.initial_flight);
    session->state.next_view_id = static_cast<int>(views.size());
    return PathInOrder(views, session->options.path.speed_m_s, session->options.path.hover_s)
        .waypoints;
  }
  const IterationFiles before{session->workspace.iteration(session->state.iterations_done - 1)};
  return ReadPath(before.path_json()).waypoints;
}

// Null for photos without a flight.
std::unique_ptr<FlownCapture> MakeVehicle(const Session& session, const SimulatedSite& site,
                                          const JobControl& job) {
  if (session.options.session.vehicle == "embedded") return nullptr;
  return std::make_unique<FlownCapture>(session.inputs, session.options, session.workspace,
                                        site.Surroundings().box.max().z(), job);
}

SparseUpdateInput SimulatedInput(const SimulatedSite& site, const Session& session) {
  SparseUpdateInput input;
  input.colmap_path = session.inputs.colmap_path;
  input.image_path = session.workspace.images();
  input.database_path = session.workspace.database();
  input.work_path = session.workspace.logs();
  input.camera = ToCamera(session.options.simulation.LowCamera());
  input.frame.origin = site.truth().origin;
  return input;
}

// Where the vehicle flies, and what it has to keep away from: the surface of the iteration before,
// or, at the first flight, nothing that is known but the straight lines that a person vouches for.
FlightTask TaskFor(const std::vector<Waypoint>& waypoints, const SparseUpdateInput& input,
                   const Session& session) {
  FlightTask task;
  task.waypoints = waypoints;
  task.site.frame.is_metric_enu = true;
  task.site.frame.origin = input.frame.origin;
  task.site.safe_distance_m = session.options.path.safe_distance_m;
  task.site.speed_m_s = session.options.path.speed_m_s;
  task.site.full_resolution = session.options.session.full_resolution;
  if (session.state.iterations_done == 0) return task;
  const IterationFiles before{session.workspace.iteration(session.state.iterations_done - 1)};
  task.site.frame = ReadWorldFrame(before.frame_json());
  task.site.surface_path = fs::absolute(before.surface_ply());
  task.site.box = BoundsOf(ReadMesh(before.surface_ply()));
  return task;
}

// Flies, and extracts the features of the photos that are there while the vehicle flies on.
void FlyAndPrepare(const std::vector<Waypoint>& waypoints, const IterationContext& context,
                   const Session& session, FlownCapture* vehicle, const JobControl& job) {
  constexpr int kBatch = 8;  // each one starts colmap once
  int prepared = 0;
  vehicle->Fly(
      TaskFor(waypoints, context.sparse, session),
      [&](int photos) {
        if (photos - prepared < kBatch) return;
        prepared = photos;
        ExtractNewFeatures(context.sparse, session.options.sparse, JobControl());
      },
      job);
}

SessionSummary RunSimulation(Session session, const JobControl& job) {
  if (IsFinished(session)) {
    job.Info("This session is finished (" + session.state.finished + ").");
    return session.summary;
  }
  job.Info("Preparing " + session.state.source);
  const SimulatedSite site(session.inputs, session.options, job);
  const Workspace& workspace = session.workspace;
  WriteMesh(site.truth().model, workspace.root() / "truth" / "model.ply");
  session.state.finished.clear();
  StereoMemory stereo_memory;
  const std::unique_ptr<FlownCapture> vehicle = MakeVehicle(session, site, job);
  while (session.state.finished.empty()) {
    AnnounceIteration(session, job);
    RemoveUnfinishedIteration(session);
    IterationContext context{workspace, &session.options, {}, {}, {}, nullptr};
    context.sparse = SimulatedInput(site, session);
    const StageTimer timer;
    const std::vector<Waypoint> waypoints = NextFlight(site, &session);
    if (vehicle) {
      FlyAndPrepare(waypoints, context, session, vehicle.get(), job);
    } else {
      site.Capture(waypoints, workspace, job);
    }
    const StageCost capture = timer.Stop();
    context.true_poses_path = SimulatedSite::TruePosesPath(workspace);
    context.truth = &site.truth();
    context.stereo_memory = &stereo_memory;
    IterationResult result = RunIteration(context, &session.state, job);
    result.summary.stage_wall_s["capture"] = capture.wall_s;
    result.summary.wall_s += capture.wall_s;
    FinishIteration(result, &session, job);
    AnnounceResult(result, job);
  }
  if (vehicle) vehicle->Finish(job);
  return session.summary;
}

// Copies an existing COLMAP project into a new workspace; the originals are never touched.
void ImportProject(const Session& session) {
  const SessionInputs& inputs = session.inputs;
  if (inputs.database_path.empty() || fs::exists(session.workspace.database())) return;
  const fs::path temporary = TemporaryPathFor(session.workspace.database());
  std::error_code error;
  fs::copy_file(inputs.database_path, temporary, fs::copy_options::overwrite_existing, error);
  if (error) throw Error(inputs.database_path.string() + ": cannot be copied: " + error.message());
  CommitTemporaryFile(temporary, session.workspace.database());
}

bool HasNewPhotos(const Session& session) {
  return session.summary.iterations.empty() ||
         static_cast<int>(ListPhotos(session.inputs.image_path).size()) >
             session.summary.iterations.back().photos;
}

SessionSummary RunOnPhotos(Session session, const JobControl& job) {
  if (ListPhotos(session.inputs.image_path).empty()) {
    throw Error(session.inputs.image_path.string() +
                ": no photo in this folder (.jpg, .png or .tif)");
  }
  if (!HasNewPhotos(session)) {
    job.Info("No new photos since the last iteration.");
    return session.summary;
  }
  AnnounceIteration(session, job);
  RemoveUnfinishedIteration(session);
  ImportProject(session);
  IterationContext context{session.workspace, &session.options, {}, {}, {}, nullptr};
  context.sparse.colmap_path = session.inputs.colmap_path;
  context.sparse.image_path = session.inputs.image_path;
  context.initial_model_path = session.inputs.sparse_path;
  if (!session.inputs.geo_path.empty()) {
    context.sparse.geo_position_of_photo = ReadGeoFile(session.inputs.geo_path);
  }
  if (!session.inputs.pose_prior_path.empty()) {
    context.sparse.local_position_of_photo = ReadPosePriorFile(session.inputs.pose_prior_path);
  }
  const IterationResult result = RunIteration(context, &session.state, job);
  FinishIteration(result, &session, job);
  AnnounceResult(result, job);
  if (!result.planning_refusal.empty()) {
    throw Error("coverage is written, but no flight was planned: " + result.planning_refusal);
  }
  return session.summary;
}

}  // namespace

void SessionInputs::Check() const {
  if (workspace_path.empty()) throw UsageError("--workspace_path is required");
  const int sources =
      (scene.empty() ? 0 : 1) + (scene_path.empty() ? 0 : 1) + (image_path.empty() ? 0 : 1);
  if (sources != 1) {
    throw UsageError("give exactly one of --scene, --scene_path and --image_path");
  }
  if (database_path.empty() != sparse_path.empty()) {
    throw UsageError("an existing project needs both --database_path and --sparse_path");
  }
  if (IsSimulation() && !(database_path.empty() && geo_path.empty() && pose_prior_path.empty())) {
    throw UsageError(
        "--database_path, --sparse_path, --geo_path and --pose_prior_path go with --image_path");
  }
  if (!scene_path.empty()) RequireFile(scene_path, "scene model");
  if (!image_path.empty()) RequireFolder(image_path, "photos");
  if (!database_path.empty()) RequireFile(database_path, "COLMAP database");
  if (!sparse_path.empty()) RequireFolder(sparse_path, "sparse model");
}

SessionSummary RunSession(const SessionInputs& inputs, const StageOptions& options,
                          const JobControl& job) {
  inputs.Check();
  ThrowIfInvalid(options.Check());
  const ColmapProgram colmap(inputs.colmap_path);  // complains before any work is done
  job.Debug("colmap: " + colmap.path().string());
  Session session = OpenSession(inputs, options);
  return inputs.IsSimulation() ? RunSimulation(std::move(session), job)
                               : RunOnPhotos(std::move(session), job);
}

}  // namespace colmap_ext
