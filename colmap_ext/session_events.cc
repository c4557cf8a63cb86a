#include "session_events.h"

#include <filesystem>
#include <sstream>

#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

std::string Ratio(const std::optional<double>& ratio) {
  return ratio ? FormatNumber("%.6f", *ratio) : "";
}

}  // namespace

void SessionEvents::OnStage(int iteration, const std::string& stage, const StageCost& cost) {
  log_->Event("stage", {{"iteration", iteration},
                        {"stage", stage},
                        {"wall_s", cost.wall_s},
                        {"cpu_s", cost.cpu_s},
                        {"peak_mib", cost.peak_mib}});
}

void SessionEvents::OnIteration(const IterationNews& news) {
  ProgramLog::Json fields = {{"iteration", news.iteration},
                             {"output_path", news.folder.string()},
                             {"finished", news.finished}};
  fields.update(SummaryToJson({news.finished, {news.summary}})["iterations"][0]);
  log_->Event("iteration", fields);
  Environment environment = EnvironmentOf(news.iteration, news.summary, news.finished);
  RunHook("on_iteration", hooks_.on_iteration, std::move(environment));
}

void SessionEvents::OnFinish(const SessionSummary& summary) {
  if (summary.iterations.empty()) return;
  const int last = static_cast<int>(summary.iterations.size()) - 1;
  RunHook("on_finish", hooks_.on_finish,
          EnvironmentOf(last, summary.iterations.back(), summary.finished));
}

SessionEvents::Environment SessionEvents::EnvironmentOf(int iteration,
                                                        const IterationSummary& summary,
                                                        const std::string& finished) const {
  const IterationFiles files{fs::absolute(workspace_.iteration(iteration))};
  return {{"COLMAP_EXT_WORKSPACE", fs::absolute(workspace_.root()).lexically_normal().string()},
          {"COLMAP_EXT_ITERATION", std::to_string(iteration)},
          {"COLMAP_EXT_ITERATION_PATH", files.folder.lexically_normal().string()},
          {"COLMAP_EXT_PHOTOS", std::to_string(summary.photos)},
          {"COLMAP_EXT_REGISTERED", std::to_string(summary.registered)},
          {"COLMAP_EXT_COVERED_RATIO", Ratio(summary.covered_ratio)},
          {"COLMAP_EXT_REACHABLE_COVERED_RATIO", Ratio(summary.reachable_covered_ratio)},
          {"COLMAP_EXT_PLANNED_VIEWS", std::to_string(summary.planned_views)},
          {"COLMAP_EXT_FINISHED", finished}};
}

void SessionEvents::RunHook(const std::string& name, const std::string& command,
                            Environment environment) {
  if (command.empty()) return;
  job_.Info("  " + name + ": " + command);
  ChildProcessOptions options;
  options.arguments = {"/bin/sh", "-c", command};
  options.environment = std::move(environment);
  options.log_path = workspace_.logs() / (name + ".log");
  fs::create_directories(workspace_.logs());
  const ChildProcessResult result = RunChildProcess(options, job_);
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) job_.Info("  " + name + "> " + line);
  log_->Event("hook", {{"name", name}, {"exit_code", result.exit_code}, {"wall_s", result.wall_s}});
  if (result.exit_code == 0) return;
  throw Error("--" + name + ": the command '" + command + "' ended with exit code " +
              std::to_string(result.exit_code) + " (its output: " + options.log_path.string() +
              "); the iteration is on disk, and the same command goes on after it");
}

}  // namespace colmap_ext
