// A session as its workspace holds it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session.h"
#include "session/seen_inputs.h"
#include "session/session_state.h"

namespace colmap_ext {

struct Session {
  SessionInputs inputs;
  StageOptions options;
  Workspace workspace;
  SessionState state;
  SessionSummary summary;
};

// Reads what is there and writes nothing. Throws UsageError when the workspace is of other photos
// than `inputs` name, Error when its files are damaged.
Session OpenSession(const SessionInputs& inputs, const StageOptions& options);

// Folder of the session's photos.
std::filesystem::path PhotoFolder(const Session& session);

// A session that ended by a limit or at its target goes on when that was raised since.
bool IsFinished(const Session& session);
// Of a person's photos.
bool HasNewPhotos(const Session& session);

// A run was stopped or killed within the iteration that comes next.
bool WasInterrupted(const Session& session);

// The path to fly in the present iteration of a simulated session; `site`: what is known of the
// place beforehand. Later ones are read back from disk, so that a session that was stopped sees the
// same numbers as one that ran through.
FlightPath FlightOfIteration(const Session& session, const RegionOfInterest& site);

// Waypoints with a photo.
int CountViews(const std::vector<Waypoint>& waypoints);

// seen.json: what the last iteration saw of photos, database and options.
std::filesystem::path SeenPath(const Workspace& workspace);
SeenInputs LookAtInputs(const Session& session);
// Against seen.json; nothing when there is none.
InputChanges ChangesSinceLastIteration(const Session& session);

}  // namespace colmap_ext
