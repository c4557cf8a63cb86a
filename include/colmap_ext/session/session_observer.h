// Who wants to know how a session goes on.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {

// An iteration that is done.
struct IterationNews {
  int iteration = 0;  // 0, 1, …
  std::filesystem::path folder;
  const IterationSummary& summary;
  std::string finished;  // why the session ends with it; empty: it goes on
};

// Called from the thread of RunSession.
class SessionObserver {
 public:
  virtual ~SessionObserver() = default;
  // A stage of iteration `iteration` ended.
  virtual void OnStage(int iteration, const std::string& stage, const StageCost& cost) = 0;
  // Everything of the iteration is on disk. What this throws ends the session; called again, the
  // session goes on with the next iteration.
  virtual void OnIteration(const IterationNews& news) = 0;
};

}  // namespace colmap_ext
