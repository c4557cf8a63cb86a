// What scripts are told of a session: events of the JSON log, and commands that a person hooked in.
#pragma once

#include <map>
#include <string>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session_observer.h"
#include "colmap_ext/util/job_control.h"
#include "program_log.h"

namespace colmap_ext {

// Shell commands (docs/file_formats.md, "Hooks"); empty: none.
struct SessionHooks {
  std::string on_iteration;  // after every iteration
  std::string on_finish;     // when the session has nothing more to do
};

class SessionEvents : public SessionObserver {
 public:
  SessionEvents(const Workspace& workspace, SessionHooks hooks, ProgramLog* log,
                const JobControl& job)
      : workspace_(workspace), hooks_(std::move(hooks)), log_(log), job_(job) {}

  void OnStage(int iteration, const std::string& stage, const StageCost& cost) override;
  // Throws Error when the command of the hook fails.
  void OnIteration(const IterationNews& news) override;
  void OnFinish(const SessionSummary& summary);

 private:
  using Environment = std::map<std::string, std::string>;

  Environment EnvironmentOf(int iteration, const IterationSummary& summary,
                            const std::string& finished) const;
  void RunHook(const std::string& name, const std::string& command, Environment environment);

  const Workspace& workspace_;
  SessionHooks hooks_;
  ProgramLog* log_;
  const JobControl& job_;
};

}  // namespace colmap_ext
