#include "colmap_ext/session/session.h"

#include <algorithm>
#include <memory>

#include "colmap_ext/mvs/stereo_memory_io.h"
#include "colmap_ext/report/session_page.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/position_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/sfm/feature_extraction.h"
#include "colmap_ext/util/disk_space.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/stage_timer.h"
#include "session/disk_need.h"
#include "session/flown_capture.h"
#include "session/iteration.h"
#include "session/open_session.h"
#include "session/simulated_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

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

// What a session tells, and to whom.
struct Listeners {
  const JobControl& job;
  SessionObserver* observer;  // may be null
};

// `finished`: why nothing is flown next; empty when the planned views are.
void AnnounceResult(const IterationSummary& summary, const std::string& finished,
                    const JobControl& job) {
  char line[160];
  std::snprintf(line, sizeof line, "  %d of %d photos registered, %.1f %% covered, ",
                summary.registered, summary.photos, 100.0 * summary.covered_ratio.value_or(0.0));
  const std::string views = std::to_string(summary.planned_views) + " views planned";
  job.Info(line + views + (finished.empty() ? "" : ", none to be flown: " + finished));
}

// The results of an iteration count from the moment the state is replaced: until then a killed
// session repeats it. `seen`: as the iteration found its inputs.
void FinishIteration(const IterationResult& result, SeenInputs seen, const Listeners& listeners,
                     Session* session) {
  const int iteration = session->state.iterations_done;
  session->summary.iterations.push_back(result.summary);
  ++session->state.iterations_done;
  session->state.finished = ReasonToFinish(*session, result.stop_reason);
  session->summary.finished = session->state.finished;
  seen.database = LookAtInputs(*session).database;
  WriteSummary(session->summary, session->workspace.summary_json());
  WriteSeenInputs(seen, SeenPath(session->workspace));
  WriteSessionState(session->state, session->workspace.state_json());
  WriteSessionPage(session->workspace, session->workspace.report(), session->inputs.image_path,
                   session->options.page, listeners.job);
  AnnounceResult(result.summary, session->state.finished, listeners.job);
  if (listeners.observer != nullptr) {
    listeners.observer->OnIteration({iteration, session->workspace.iteration(iteration),
                                     session->summary.iterations.back(), session->state.finished});
  }
}

void RemoveUnfinishedIteration(const Session& session) {
  std::error_code error;
  fs::remove_all(session.workspace.iteration(session.state.iterations_done), error);
  if (error) {
    throw Error(session.workspace.iteration(session.state.iterations_done).string() +
                ": cannot remove what an interrupted run left: " + error.message());
  }
}

int PhotosBefore(const Session& session) {
  return session.summary.iterations.empty() ? 0 : session.summary.iterations.back().photos;
}

// Stereo needs the pixels of every photo of the model. It would miss them only after the new photos
// had come into the database without their matches to the missing one, which come once.
void RequirePhotosOfModel(const Session& session) {
  if (session.summary.iterations.empty()) return;
  const std::vector<std::string>& unregistered = session.summary.iterations.back().unregistered;
  for (const std::string& name : ChangesSinceLastIteration(session).removed_photos) {
    if (std::ranges::find(unregistered, name) != unregistered.end()) continue;
    throw Error((PhotoFolder(session) / name).string() +
                ": this photo of the session's model is gone; put it back, or start a new "
                "workspace");
  }
}

// Removes what an interrupted run left and makes the iteration's folder, which shows from now on
// that the iteration began. Throws Error when the disk has no room for it.
void BeginIteration(const Session& session, int new_photos, const JobControl& job) {
  RequirePhotosOfModel(session);
  RemoveUnfinishedIteration(session);
  const DiskNeed need =
      EstimateDiskNeed(session.options, session.inputs.IsSimulation(), PhotosBefore(session),
                       new_photos, session.state.iterations_done);
  const std::uint64_t free_bytes = FreeDiskBytes(session.workspace.root());
  if (const std::string complaint = DiskComplaint(need, free_bytes, session.workspace.root());
      !complaint.empty()) {
    throw Error(complaint);
  }
  if (const std::string warning = DiskWarning(need, free_bytes, session.workspace.root());
      !warning.empty()) {
    job.Warn(warning);
  }
  fs::create_directories(session.workspace.iteration(session.state.iterations_done));
}

void AnnounceIteration(const Session& session, const JobControl& job) {
  job.Info("Iteration " + std::to_string(session.state.iterations_done + 1));
}

// The path to fly in the present iteration.
std::vector<Waypoint> NextFlight(const SimulatedSite& site, Session* session) {
  const std::vector<Waypoint> waypoints =
      FlightOfIteration(*session, site.Surroundings()).waypoints;
  if (session->state.iterations_done == 0) {
    session->state.next_view_id = CountViews(waypoints);
  }
  return waypoints;
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

// What the iteration before found out about the place.
void AddKnownSite(const Session& session, FlightSite* site) {
  const IterationFiles before{session.workspace.iteration(session.state.iterations_done - 1)};
  site->frame = ReadWorldFrame(before.frame_json());
  site->surface_path = fs::absolute(before.surface_ply());
  site->box = BoundsOf(ReadMesh(before.surface_ply()));
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
  if (session.state.iterations_done > 0) AddKnownSite(session, &task.site);
  PathOptions path = session.options.path;
  ReadZones(task.site.frame, &path);
  task.site.limits = path.limits;
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
        job.Info("  features of the first " + std::to_string(photos) + " photos, in flight");
      },
      job);
}

// The meshes of all photos as the finished iterations solved them, each as the latest one did. Of
// iterations by a version that kept none there are none, and all photos are solved again.
StereoMemory KnownMeshes(const Session& session) {
  StereoMemory memory;
  for (int i = session.state.iterations_done - 1; i >= 0; --i) {
    const fs::path file = IterationFiles{session.workspace.iteration(i)}.stereo_bin();
    if (fs::exists(file)) ReadStereoMemory(file, &memory);
  }
  return memory;
}

SessionSummary RunSimulation(Session session, const Listeners& listeners) {
  const JobControl& job = listeners.job;
  if (IsFinished(session)) {
    job.Info("This session is finished (" + session.state.finished + ").");
    return session.summary;
  }
  job.Info("Preparing " + session.state.source);
  const SimulatedSite site(session.inputs, session.options, job);
  const Workspace& workspace = session.workspace;
  WriteMesh(site.truth().model, workspace.root() / "truth" / "model.ply");
  session.state.finished.clear();
  StereoMemory stereo_memory = KnownMeshes(session);
  const std::unique_ptr<FlownCapture> vehicle = MakeVehicle(session, site, job);
  while (session.state.finished.empty()) {
    AnnounceIteration(session, job);
    IterationContext context{workspace, &session.options, {}, {}, {}, nullptr};
    context.sparse = SimulatedInput(site, session);
    context.observer = listeners.observer;
    const StageTimer timer;
    const std::vector<Waypoint> waypoints = NextFlight(site, &session);
    BeginIteration(session, CountViews(waypoints), job);
    if (vehicle) {
      FlyAndPrepare(waypoints, context, session, vehicle.get(), job);
    } else {
      site.Capture(waypoints, workspace, job);
    }
    const StageCost capture = timer.Stop();
    if (context.observer != nullptr) {
      context.observer->OnStage(session.state.iterations_done, "capture", capture);
    }
    const SeenInputs seen = LookAtInputs(session);
    context.true_poses_path = SimulatedSite::TruePosesPath(workspace);
    context.truth = &site.truth();
    context.stereo_memory = &stereo_memory;
    IterationResult result = RunIteration(context, &session.state, job);
    result.summary.stage_wall_s["capture"] = capture.wall_s;
    result.summary.wall_s += capture.wall_s;
    FinishIteration(result, seen, listeners, &session);
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

SparseUpdateInput PhotosInput(const Session& session) {
  SparseUpdateInput input;
  input.colmap_path = session.inputs.colmap_path;
  input.image_path = PhotoFolder(session);
  input.database_path = session.workspace.database();
  input.work_path = session.workspace.logs();
  if (!session.inputs.geo_path.empty()) {
    input.geo_position_of_photo = ReadGeoFile(session.inputs.geo_path);
  }
  if (!session.inputs.pose_prior_path.empty()) {
    input.local_position_of_photo = ReadPosePriorFile(session.inputs.pose_prior_path);
  }
  return input;
}

// How many photos there are. Throws Error when there is none.
int RequirePhotos(const fs::path& folder) {
  const auto photos = static_cast<int>(ListPhotos(folder).size());
  if (photos == 0) {
    throw Error(folder.string() + ": no photo in this folder (.jpg, .png or .tif)");
  }
  return photos;
}

// One iteration over the photos that are in the session's folder.
void IterateOnPhotos(StereoMemory* stereo_memory, const Listeners& listeners, Session* session) {
  IterationContext context{session->workspace, &session->options, {}, {}, {}, nullptr};
  context.observer = listeners.observer;
  context.stereo_memory = stereo_memory;
  context.sparse = PhotosInput(*session);
  context.initial_model_path = session->inputs.sparse_path;
  const SeenInputs seen = LookAtInputs(*session);
  const IterationResult result = RunIteration(context, &session->state, listeners.job);
  FinishIteration(result, seen, listeners, session);
  if (!result.planning_refusal.empty()) {
    throw Error("coverage is written, but no flight was planned: " + result.planning_refusal);
  }
}

SessionSummary RunOnPhotos(Session session, const Listeners& listeners) {
  const JobControl& job = listeners.job;
  const int photos = RequirePhotos(session.inputs.image_path);
  if (!HasNewPhotos(session)) {
    job.Info("No new photos since the last iteration.");
    return session.summary;
  }
  AnnounceIteration(session, job);
  BeginIteration(session, std::max(0, photos - PhotosBefore(session)), job);
  ImportProject(session);
  StereoMemory stereo_memory = KnownMeshes(session);
  IterateOnPhotos(&stereo_memory, listeners, &session);
  return session.summary;
}

// A person's photos beside those that the vehicle takes; the originals are never touched. From here
// on the session's photos are the workspace's.
void TakePersonsPhotos(Session* session) {
  const fs::path from = session->inputs.image_path, to = session->workspace.images();
  RequirePhotos(from);
  const std::string own = SimulatedSite::PhotoName(0).substr(0, 5);
  for (const std::string& name : ListPhotos(from)) {
    if (fs::exists(to / name)) continue;
    if (name.starts_with(own)) {
      throw Error((from / name).string() + ": photos named " + own +
                  "… are the vehicle's own; give this one another name");
    }
    WriteFileAtomically(to / name, ReadFile(from / name));
  }
  session->inputs.image_path.clear();
}

int CountPhotos(const Session& session) {
  return static_cast<int>(ListPhotos(PhotoFolder(session)).size());
}

// After a person's photos a real vehicle takes the next ones.
SessionSummary RunWithVehicle(Session session, const Listeners& listeners) {
  const JobControl& job = listeners.job;
  if (IsFinished(session) && CountPhotos(session) <= PhotosBefore(session)) {
    job.Info("This session is finished (" + session.state.finished + ").");
    return session.summary;
  }
  session.state.finished.clear();
  ImportProject(session);
  StereoMemory stereo_memory = KnownMeshes(session);
  std::unique_ptr<FlownCapture> vehicle;
  while (session.state.finished.empty()) {
    AnnounceIteration(session, job);
    BeginIteration(session, std::max(0, CountPhotos(session) - PhotosBefore(session)), job);
    if (session.state.iterations_done > 0) {
      if (!vehicle) {
        vehicle = std::make_unique<FlownCapture>(session.inputs, session.options, session.workspace,
                                                 0, job);
      }
      IterationContext context{session.workspace, &session.options, {}, {}, {}, nullptr};
      context.sparse = PhotosInput(session);
      FlyAndPrepare(FlightOfIteration(session, {}).waypoints, context, session, vehicle.get(), job);
      if (CountPhotos(session) <= PhotosBefore(session)) {
        throw Error("the flight brought no photo");
      }
    }
    IterateOnPhotos(&stereo_memory, listeners, &session);
  }
  if (vehicle) vehicle->Finish(job);
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
                          const JobControl& job, SessionObserver* observer) {
  inputs.Check();
  ThrowIfInvalid(options.Check());
  const ColmapProgram colmap(inputs.colmap_path);  // complains before any work is done
  job.Debug("colmap: " + colmap.path().string());
  const bool is_flown = options.session.IsRealVehicle();
  if (inputs.IsSimulation() && is_flown) {
    throw UsageError("--Session.vehicle " + options.session.vehicle +
                     ": a real vehicle photographs a real site: give --image_path with the first "
                     "photos instead of a scene");
  }
  RequireWritableFolder(inputs.workspace_path, "workspace");
  Session session = OpenSession(inputs, options);
  if (is_flown) TakePersonsPhotos(&session);
  const InputChanges changes = ChangesSinceLastIteration(session);
  for (const std::string& warning : changes.warnings) job.Warn(warning);
  for (const std::string& note : changes.notes) job.Info(note);
  const Listeners listeners{job, observer};
  if (is_flown) return RunWithVehicle(std::move(session), listeners);
  return inputs.IsSimulation() ? RunSimulation(std::move(session), listeners)
                               : RunOnPhotos(std::move(session), listeners);
}

}  // namespace colmap_ext
