// One iteration of the loop over the photos that are there.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "colmap_ext/mvs/stereo_memory.h"
#include "colmap_ext/report/summary.h"
#include "colmap_ext/scene/truth.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session_observer.h"
#include "colmap_ext/session/session_options.h"
#include "session/session_state.h"

namespace colmap_ext {

// What an iteration works on besides the workspace. What it refers to must outlive it.
struct IterationContext {
  const Workspace& workspace;
  const StageOptions* options;
  SparseUpdateInput sparse;  // without the earlier model, which is read from the iteration before
  std::filesystem::path initial_model_path;  // model to start from; empty for none
  std::filesystem::path true_poses_path;     // empty without truth
  const GroundTruth* truth = nullptr;        // null without truth
  StereoMemory* stereo_memory = nullptr;     // of the iterations before; updated, never null
  SessionObserver* observer = nullptr;       // told of every stage; null for none
};

struct IterationResult {
  IterationSummary summary;
  std::string stop_reason;  // empty: there are views to fly
  std::string
      planning_refusal;  // why no flight was planned from this model; empty: it was, or is done
};

// Runs every stage from the sparse model to the path and writes iterations/NNN/. `state` gives the
// iteration's number and the next view id; its region is set at the first one.
IterationResult RunIteration(const IterationContext& context, SessionState* state,
                             const JobControl& job);

}  // namespace colmap_ext
