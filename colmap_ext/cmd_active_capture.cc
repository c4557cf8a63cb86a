#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "ask_yes.h"
#include "colmap_ext/report/page_server.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/forecast.h"
#include "colmap_ext/session/presets.h"
#include "colmap_ext/session/session.h"
#include "colmap_ext/session/session_lock.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "session_events.h"

namespace colmap_ext {
namespace {

void BindInputs(OptionSet& set, SessionInputs* inputs) {
  set.Add("", "workspace_path", &inputs->workspace_path,
          "folder of the session; created, or gone on with");
  set.Add("", "scene", &inputs->scene, "simulate this built-in scene: church, boxes or gate");
  set.Add("", "scene_path", &inputs->scene_path,
          "simulate this textured model (OBJ, glTF, COLLADA)");
  set.Add("", "image_path", &inputs->image_path, "folder of your own photos (only read)");
  set.Add("", "database_path", &inputs->database_path,
          "existing COLMAP database to start from (copied)");
  set.Add("", "sparse_path", &inputs->sparse_path,
          "existing COLMAP model to start from (only read)");
  set.Add("", "geo_path", &inputs->geo_path, "positions of photos: lines of name lon lat alt");
  set.Add("", "pose_prior_path", &inputs->pose_prior_path,
          "positions of photos in local metres: lines of name x y z");
  set.Add("", "picture_url", &inputs->picture_url,
          "real vehicle: where its camera's pictures are, with {index} and {resolution}");
  set.Add("", "capture_folder", &inputs->capture_folder,
          "real vehicle: folder in which somebody else puts the pictures");
  set.Add("", "yes", &inputs->yes, "real vehicle: do not ask before it arms");
  set.Add("", "colmap_path", &inputs->colmap_path, "the colmap program; default: on the PATH");
}

// What the command itself takes, besides the session's own.
struct CaptureOptions {
  std::string preset, vehicle;
  int serve_port = 0;
  bool status = false, dry_run = false;
  SessionHooks hooks;
};

void BindOptions(OptionSet& set, CaptureOptions* o) {
  set.Add("", "preset", &o->preset,
          "size of the site: outdoor or indoor; default: indoor for boxes; "
          "your own photos are fitted to what they resolve (--Session.fit_to_site)");
  set.Add("", "serve", &o->serve_port,
          "show the session on a page at http://127.0.0.1:PORT/ while it runs, and "
          "after, until Ctrl-C; 0: any free port");
  set.Add("", "vehicle", &o->vehicle, "the same as --Session.vehicle (docs/flying.md)");
  set.Add("", "status", &o->status, "only say how far the session of this workspace is");
  set.Add("", "dry_run", &o->dry_run,
          "only say what would be done: stages, photos, flight, room on the disk");
  set.Add("", "on_iteration", &o->hooks.on_iteration,
          "shell command to run after every iteration (docs/file_formats.md, Hooks)");
  set.Add("", "on_finish", &o->hooks.on_finish,
          "shell command to run when the session has nothing more to do");
}

int ShowStatus(const SessionInputs& inputs, ProgramLog* log) {
  const SessionStatus status = ReadSessionStatus(inputs.workspace_path);
  std::cout << StatusText(status);
  log->Result(StatusToJson(status));
  return 0;
}

int ShowForecast(const SessionInputs& inputs, const StageOptions& options, ProgramLog* log) {
  const SessionForecast forecast = ForecastSession(inputs, options);
  std::cout << ForecastText(forecast);
  log->Result(ForecastToJson(forecast));
  return 0;
}

// Options of the workspace's session, and those that follow from others.
void CompleteOptions(const SessionInputs& inputs, CaptureOptions* capture, OptionSet* set,
                     StageOptions* options) {
  const Workspace workspace(inputs.workspace_path);
  if (capture->vehicle.empty() && set->IsSet("Session.vehicle")) {
    capture->vehicle = options->session.vehicle;
  }
  // One of the two names is enough to remember.
  const std::string vehicle = std::exchange(capture->vehicle, "");
  if (std::filesystem::exists(workspace.session_ini())) set->ParseIniFile(workspace.session_ini());
  std::string preset = capture->preset;
  if (!inputs.image_path.empty() && preset.empty() && !set->IsSet("Session.fit_to_site")) {
    options->session.fit_to_site = !set->IsSet("Coverage.ground_sampling_distance_mm");
  }
  if (!vehicle.empty()) options->session.vehicle = vehicle;
  if (preset.empty()) preset = inputs.scene == "boxes" ? "indoor" : "outdoor";
  ApplyPreset(preset, *set, options);
}

// What a person who flies by hand does next; empty for all others.
std::string NextSteps(const SessionInputs& inputs, const StageOptions& options,
                      const SessionSummary& summary) {
  const std::string& vehicle = options.session.vehicle;
  const bool by_hand = !inputs.IsSimulation() && (vehicle == "simulated" || vehicle == "embedded");
  if (!by_hand || !summary.finished.empty() || summary.iterations.empty()) return "";
  const Workspace workspace(inputs.workspace_path);
  const IterationFiles files{workspace.iteration(static_cast<int>(summary.iterations.size()) - 1)};
  const std::string page = (workspace.report() / "index.html").string();
  const std::string again = "put the new photos\ninto " + inputs.image_path.string() +
                            " and run the same command again.\n";
  if (std::filesystem::exists(files.mission_plan())) {
    return "Next: look at " + page + ", fly " + files.mission_plan().string() + ", " + again;
  }
  return "Next: look at " + page +
         ", make a mission file by mission_exporter with\n--Mission.home_below_origin_m, fly it, " +
         again;
}

int RunWithPage(SessionInputs inputs, const StageOptions& options, const CaptureOptions& capture,
                const std::string& session_ini, bool serves, Program* program) {
  const Workspace workspace(inputs.workspace_path);
  std::optional<SessionLock> lock(std::in_place, workspace);
  WriteFileAtomically(workspace.session_ini(), session_ini);
  std::unique_ptr<PageServer> server;
  if (serves) {
    server =
        std::make_unique<PageServer>(workspace, options.page, capture.serve_port, &program->log);
    server->Message(LogLevel::kInfo, "The session's page: " + server->url());
  }
  ProgressSink* const sink = server ? static_cast<ProgressSink*>(server.get()) : &program->log;
  const JobControl job(sink, &program->cancel);
  inputs.confirm = [&job](const std::string& checklist) { return AskYes(checklist, job); };
  SessionEvents events(workspace, capture.hooks, &program->log, job);
  const SessionSummary summary = RunSession(inputs, options, job, &events);
  std::cout << '\n' << SummaryTable(summary) << NextSteps(inputs, options, summary) << std::flush;
  program->log.Result(SummaryToJson(summary));
  events.OnFinish(summary);
  lock.reset();
  if (server) {
    server->Finish();
    job.Info("The page stays at " + server->url() + " until Ctrl-C");
    PageServer::WaitUntilCancelled(job);
  }
  return 0;
}

}  // namespace

int RunActiveCapture(const Arguments& arguments, Program& program) {
  CommandLine line(
      "active_capture",
      "The whole loop. With --scene or --scene_path: a simulated drone flies until every "
      "reachable part is covered. With --image_path: one iteration over your photos, "
      "ending with coverage map, next views, path and a QGroundControl mission; run it "
      "again when there are new photos. With --image_path and --vehicle: a real vehicle flies "
      "from there on. A session that was stopped goes on.");
  SessionInputs inputs;
  StageOptions options;
  CaptureOptions capture;
  BindInputs(line.options(), &inputs);
  BindOptions(line.options(), &capture);
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  RequireOption(inputs.workspace_path, "workspace_path");
  if (capture.status) return ShowStatus(inputs, &program.log);
  // Is given anew each time: what is remembered does not arm a vehicle.
  const bool yes = std::exchange(inputs.yes, false);
  CompleteOptions(inputs, &capture, &line.options(), &options);
  const std::string session_ini = line.options().ToIni();
  inputs.yes = yes;
  inputs.Check();
  ThrowIfInvalid(options.Check());
  if (capture.dry_run) return ShowForecast(inputs, options, &program.log);
  RequireWritableFolder(inputs.workspace_path, "workspace");
  return RunWithPage(inputs, options, capture, session_ini, line.options().IsSet("serve"),
                     &program);
}

}  // namespace colmap_ext
