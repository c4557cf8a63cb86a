// What the commands of single stages take from a workspace that a session made, so that they give
// what the session gave.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {

// A path option of a command, by name without dashes.
struct PathOption {
  const char* name;
  const std::filesystem::path& value;
};

// A command works in a workspace or on files: throws UsageError unless either `workspace_path` is
// given and none of `files`, or all of `files`; Error when there is no such workspace.
void RequireWorkspaceOrFiles(const std::filesystem::path& workspace_path,
                             const std::vector<PathOption>& files);

// Files of the newest iteration. Throws Error when the workspace has none.
IterationFiles LatestIterationFiles(const Workspace& workspace);

// Takes from session.ini, when there is one, the options that the command line did not give.
void TakeSessionOptions(const Workspace& workspace, OptionSet* set);

// Width to which the session scales photos for the dense stages, px; the default of a session when
// there is no session.ini.
int SessionImageWidth(const Workspace& workspace);

// The photos of a sparse model without their pixels, cameras scaled to at most `max_width_px`.
PhotoSet LoadPosesOnly(const std::filesystem::path& sparse_path, int max_width_px);

// The region that `options` give, else the one that the session fixed, else the default one of the
// first iteration's photos.
RegionOfInterest RegionOfWorkspace(const Workspace& workspace, const RegionOptions& options);

// frame.json of an iteration; without one the model is taken to be metric, z up.
WorldFrame FrameOrMetric(const std::filesystem::path& frame_json);

// The frame of a sparse model: frame.json in its folder (sparse_updater) or beside it (a session's
// iteration), else metric as above.
WorldFrame FrameOfModel(const std::filesystem::path& sparse_path);

// Sets the entry of one stage in timing.json and keeps the others.
void RecordStageCost(const std::filesystem::path& timing_json, const std::string& stage,
                     const StageCost& cost);

}  // namespace colmap_ext
