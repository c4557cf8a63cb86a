#include "simulated_session.h"

#include "bench_program.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/workspace.h"

namespace colmap_ext {

SessionSummary RunSimulatedSession(const std::filesystem::path& workspace,
                                   const std::vector<std::string>& arguments,
                                   const JobControl& job) {
  const std::filesystem::path summary_json = Workspace(workspace).summary_json();
  const bool has_ended =
      std::filesystem::exists(summary_json) && !ReadSummary(summary_json).finished.empty();
  if (!has_ended) {
    std::vector<std::string> all{"active_capture", "--workspace_path", workspace.string(),
                                 "--Session.vehicle", "embedded"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    RunColmapExt(std::move(all), workspace.string() + ".log", job);
  }
  return ReadSummary(summary_json);
}

}  // namespace colmap_ext
