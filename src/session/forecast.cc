#include "colmap_ext/session/forecast.h"

#include <algorithm>

#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/session/session_lock.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/disk_space.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"
#include "session/disk_need.h"
#include "session/open_session.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kCoarseTextures = 16;  // only the shape is wanted

std::string Minutes(double seconds) { return FormatNumber("%.1f min", seconds / 60); }

RegionOfInterest SiteOf(const SessionInputs& inputs, const StageOptions& options) {
  const TexturedScene scene =
      inputs.scene.empty() ? LoadScene(inputs.scene_path, LoadSceneOptions(), JobControl())
                           : MakeScene(inputs.scene, options.simulation.seed, kCoarseTextures);
  return {BoundsOf(scene.Truth().model)};
}

void AddFlight(const Session& session, SessionForecast* forecast) {
  const RegionOfInterest site = session.state.iterations_done == 0
                                    ? SiteOf(session.inputs, session.options)
                                    : RegionOfInterest();
  const FlightPath path = FlightOfIteration(session, site);
  forecast->new_photos = CountViews(path.waypoints);
  forecast->flight_length_m = path.length_m;
  forecast->flight_duration_s = path.duration_s;
}

std::vector<std::string> StagesOfSession(const Session& session) {
  std::vector<std::string> stages;
  if (session.inputs.IsSimulation()) stages = {"capture"};
  for (const char* stage :
       {"sparse", "superpixels", "stereo", "fusion", "surface", "coverage", "nbv", "path"}) {
    stages.emplace_back(stage);
  }
  if (session.inputs.IsSimulation()) stages.emplace_back("evaluation");
  if (session.options.session.pictures) stages.emplace_back("pictures");
  return stages;
}

std::string WhyNothing(const Session& session) {
  if (session.inputs.IsSimulation()) {
    return IsFinished(session) ? FinishedSentence(session.state.finished) : "";
  }
  if (ListPhotos(session.inputs.image_path).empty()) {
    return session.inputs.image_path.string() + " has no photos";
  }
  return HasNewPhotos(session) ? "" : "no new photos since the last iteration";
}

// A path that the session would fly next.
void AddNextFlight(const Workspace& workspace, SessionStatus* status) {
  if (status->summary.iterations.empty() || !status->summary.finished.empty()) return;
  const IterationFiles last{
      workspace.iteration(static_cast<int>(status->summary.iterations.size()) - 1)};
  if (!fs::exists(last.path_json())) return;
  const FlightPath path = ReadPath(last.path_json());
  status->length_m = path.length_m;
  status->duration_s = path.duration_s;
}

std::string Percent(double ratio) { return FormatNumber("%.1f %%", 100 * ratio); }

}  // namespace

SessionStatus ReadSessionStatus(const fs::path& workspace_path) {
  const Workspace workspace(workspace_path);
  RequireFolder(workspace_path, "workspace");
  SessionStatus status;
  status.workspace_path = workspace_path;
  status.process = SessionLock::HolderOf(workspace);
  if (!fs::exists(workspace.state_json())) {
    if (!status.process && !fs::exists(workspace.session_ini())) {
      throw Error(workspace_path.string() + ": there is no session in this folder");
    }
    status.was_interrupted = !status.process;
    return status;  // its first iteration is not done yet
  }
  const SessionState state = ReadSessionState(workspace.state_json());
  status.source = state.source;
  status.summary = ReadSummary(workspace.summary_json());
  const auto done = static_cast<std::size_t>(std::max(0, state.iterations_done));
  if (status.summary.iterations.size() > done) status.summary.iterations.resize(done);
  status.summary.finished = state.finished;
  status.was_interrupted =
      !status.process && fs::exists(workspace.iteration(state.iterations_done));
  AddNextFlight(workspace, &status);
  return status;
}

std::string StatusText(const SessionStatus& status) {
  std::string text = status.workspace_path.string() + ": " +
                     (status.source.empty() ? "a session at its first iteration" : status.source);
  text += "\nrunning:    ";
  if (!status.process) {
    text += status.was_interrupted ? "no; a run was stopped, the same command goes on" : "no";
  } else {
    text += *status.process > 0 ? "yes, process " + std::to_string(*status.process) : "yes";
  }
  const std::vector<IterationSummary>& iterations = status.summary.iterations;
  text += "\niterations: " + std::to_string(iterations.size()) + " done";
  if (!status.summary.finished.empty()) {
    text += "; " + FinishedSentence(status.summary.finished);
  }
  if (!iterations.empty()) {
    const IterationSummary& last = iterations.back();
    text += "\nphotos:     " + std::to_string(last.registered) + " of " +
            std::to_string(last.photos) + " registered";
    if (last.covered_ratio) text += "\ncovered:    " + Percent(*last.covered_ratio);
    if (last.reachable_covered_ratio) {
      text += ", " + Percent(*last.reachable_covered_ratio) + " of what can be reached";
    }
    if (last.mean_error_m) {
      text += FormatNumber("\nmean error: %.1f mm", 1000 * *last.mean_error_m);
    }
  }
  if (status.length_m) {
    text += "\nnext:       " + std::to_string(iterations.back().planned_views) + " views, " +
            FormatNumber("%.0f m, ", *status.length_m) + Minutes(*status.duration_s);
  }
  return text + "\n";
}

Json StatusToJson(const SessionStatus& status) {
  Json json = {{"workspace_path", status.workspace_path.string()},
               {"source", status.source},
               {"running", status.process.has_value()},
               {"was_interrupted", status.was_interrupted},
               {"iterations_done", status.summary.iterations.size()},
               {"finished", status.summary.finished}};
  if (status.process && *status.process > 0) json["process"] = *status.process;
  if (!status.summary.iterations.empty()) {
    json["last"] = SummaryToJson(status.summary)["iterations"].back();
  }
  if (status.length_m) json["next_length_m"] = *status.length_m;
  if (status.duration_s) json["next_duration_s"] = *status.duration_s;
  return json;
}

SessionForecast ForecastSession(const SessionInputs& inputs, const StageOptions& options) {
  inputs.Check();
  ThrowIfInvalid(options.Check());
  const Session session = OpenSession(inputs, options);
  SessionForecast forecast;
  forecast.source = session.state.source;
  forecast.iteration = session.state.iterations_done;
  forecast.nothing_to_do = WhyNothing(session);
  forecast.disk_free_bytes = FreeDiskBytes(inputs.workspace_path);
  const InputChanges changes = ChangesSinceLastIteration(session);
  forecast.changes = changes.warnings;
  forecast.changes.insert(forecast.changes.end(), changes.notes.begin(), changes.notes.end());
  const std::vector<IterationSummary>& iterations = session.summary.iterations;
  if (!iterations.empty()) forecast.photos_before = iterations.back().photos;
  if (!forecast.nothing_to_do.empty()) return forecast;

  forecast.stages = StagesOfSession(session);
  if (inputs.IsSimulation()) {
    AddFlight(session, &forecast);
  } else {
    const auto photos = static_cast<int>(ListPhotos(inputs.image_path).size());
    forecast.new_photos = std::max(0, photos - forecast.photos_before);
  }
  if (!iterations.empty() && forecast.photos_before > 0) {
    forecast.work_s = iterations.back().wall_s * (forecast.photos_before + forecast.new_photos) /
                      forecast.photos_before;
  }
  const DiskNeed need = EstimateDiskNeed(options, inputs.IsSimulation(), forecast.photos_before,
                                         forecast.new_photos, session.state.iterations_done);
  forecast.disk_next_bytes = need.next_bytes;
  forecast.disk_session_bytes = need.session_bytes;
  return forecast;
}

std::string ForecastText(const SessionForecast& forecast) {
  std::string text = forecast.source + ", iteration " + std::to_string(forecast.iteration + 1);
  for (const std::string& change : forecast.changes) text += "\nchanged:  " + change;
  if (!forecast.nothing_to_do.empty()) {
    return text + "\nnothing to do: " + forecast.nothing_to_do + "\n";
  }
  text += "\nstages:  ";
  for (const std::string& stage : forecast.stages) text += " " + stage;
  text += "\nphotos:   " + std::to_string(forecast.new_photos) + " new, " +
          std::to_string(forecast.photos_before) + " there";
  if (forecast.flight_length_m) {
    text += "\nflight:   " + FormatNumber("%.0f m, ", *forecast.flight_length_m) +
            Minutes(*forecast.flight_duration_s);
  }
  text += "\nwork:     " + (forecast.work_s ? "about " + Minutes(*forecast.work_s)
                                            : std::string("not known before the first iteration"));
  text += "\ndisk:     about " + BytesText(forecast.disk_next_bytes) + " for this iteration, " +
          BytesText(forecast.disk_session_bytes) + " up to the session's limits; " +
          BytesText(forecast.disk_free_bytes) + " free";
  if (forecast.disk_free_bytes < forecast.disk_next_bytes) text += ": NOT ENOUGH";
  return text + "\nNothing was done and nothing was written.\n";
}

Json ForecastToJson(const SessionForecast& forecast) {
  Json json = {{"source", forecast.source},
               {"iteration", forecast.iteration},
               {"nothing_to_do", forecast.nothing_to_do},
               {"changes", forecast.changes},
               {"stages", forecast.stages},
               {"photos_before", forecast.photos_before},
               {"new_photos", forecast.new_photos},
               {"disk_next_bytes", forecast.disk_next_bytes},
               {"disk_session_bytes", forecast.disk_session_bytes},
               {"disk_free_bytes", forecast.disk_free_bytes}};
  if (forecast.flight_length_m) json["flight_length_m"] = *forecast.flight_length_m;
  if (forecast.flight_duration_s) json["flight_duration_s"] = *forecast.flight_duration_s;
  if (forecast.work_s) json["work_s"] = *forecast.work_s;
  return json;
}

}  // namespace colmap_ext
