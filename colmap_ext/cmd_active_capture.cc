#include <iostream>
#include <memory>

#include "colmap_ext/report/page_server.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/presets.h"
#include "colmap_ext/session/session.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"

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

}  // namespace

int RunActiveCapture(const Arguments& arguments, Program& program) {
  CommandLine line(
      "active_capture",
      "The whole loop. With --scene or --scene_path: a simulated drone flies until every "
      "reachable part is covered. With --image_path: one iteration over your photos, "
      "ending with coverage map, next views, path and a QGroundControl mission; run it "
      "again when there are new photos. A session that was stopped goes on.");
  SessionInputs inputs;
  StageOptions options;
  std::string preset, vehicle;
  int serve_port = 0;
  BindInputs(line.options(), &inputs);
  line.options().Add("", "preset", &preset,
                     "size of the site: outdoor or indoor; default: indoor for boxes; "
                     "your own photos are fitted to what they resolve (--Session.fit_to_site)");
  line.options().Add("", "serve", &serve_port,
                     "show the session on a page at http://127.0.0.1:PORT/ while it runs, and "
                     "after, until Ctrl-C; 0: any free port");
  line.options().Add("", "vehicle", &vehicle, "the same as --Session.vehicle");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  RequireOption(inputs.workspace_path, "workspace_path");

  const Workspace workspace(inputs.workspace_path);
  if (std::filesystem::exists(workspace.session_ini())) {
    line.options().ParseIniFile(workspace.session_ini());
  }
  if (!inputs.image_path.empty() && preset.empty() &&
      !line.options().IsSet("Session.fit_to_site")) {
    options.session.fit_to_site = !line.options().IsSet("Coverage.ground_sampling_distance_mm");
  }
  if (!vehicle.empty()) options.session.vehicle = vehicle;
  if (preset.empty()) preset = inputs.scene == "boxes" ? "indoor" : "outdoor";
  ApplyPreset(preset, line.options(), &options);
  inputs.Check();
  ThrowIfInvalid(options.Check());
  RequireWritableFolder(inputs.workspace_path, "workspace");
  WriteFileAtomically(workspace.session_ini(), line.options().ToIni());

  std::unique_ptr<PageServer> server;
  if (line.options().IsSet("serve")) {
    server = std::make_unique<PageServer>(workspace, options.page, serve_port, &program.log);
    server->Message(LogLevel::kInfo, "The session's page: " + server->url());
  }
  ProgressSink* const sink = server ? static_cast<ProgressSink*>(server.get()) : &program.log;
  const JobControl job(sink, &program.cancel);
  const SessionSummary summary = RunSession(inputs, options, job);
  std::cout << '\n' << SummaryTable(summary);
  program.log.Result(SummaryToJson(summary));
  if (server) {
    server->Finish();
    job.Info("The page stays at " + server->url() + " until Ctrl-C");
    PageServer::WaitUntilCancelled(job);
  }
  return 0;
}

}  // namespace colmap_ext
