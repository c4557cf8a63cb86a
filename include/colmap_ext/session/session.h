// The loop: photos, sparse model, fast mesh, surface, coverage, next views, path, flight, photos.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/session/session_observer.h"
#include "colmap_ext/session/session_options.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Where a session's photos come from. Exactly one of: a simulated scene (`scene` or `scene_path`),
// or a person's photos (`image_path`).
struct SessionInputs {
  std::filesystem::path workspace_path;

  std::string scene;                 // "church", "boxes" or "gate"
  std::filesystem::path scene_path;  // any textured model

  std::filesystem::path image_path;       // folder of photos, read only
  std::filesystem::path database_path;    // an existing COLMAP database to start from (copied)
  std::filesystem::path sparse_path;      // an existing sparse model to start from (copied)
  std::filesystem::path geo_path;         // geo.txt: name lon lat alt
  std::filesystem::path pose_prior_path;  // name x y z, local metres
  std::string colmap_path;                // program; empty: `colmap` on the PATH

  // A real vehicle (SessionOptions::vehicle): where its camera's pictures are (see DaemonOptions).
  std::string picture_url;
  std::filesystem::path capture_folder;
  bool yes = false;  // do not ask before it arms
  // Asks a person, who sees this checklist, whether the vehicle may arm. Without it (and without
  // `yes`) no real vehicle starts.
  std::function<bool(const std::string& checklist)> confirm;

  // Throws UsageError for a combination that makes no sense, Error for a folder that is not there.
  void Check() const;
  bool IsSimulation() const { return !scene.empty() || !scene_path.empty(); }
};

// Runs the session, or goes on with it from what the workspace holds.
//
// Simulation: flies the first rectangle, then iterates until no reachable iso-point is uncovered or
// a limit is met. A person's photos: one iteration over the photos that are there; called again
// when there are new ones, one more. A person's photos and a real vehicle: they are copied into the
// workspace, and the vehicle adds its own until the same end as in simulation. Each finished
// iteration is on disk (iterations/NNN, summary.json, report/) before the next begins. Returns the
// summary of all iterations.
//
// Throws Error when a stage cannot do its work, or, after coverage was written, when no flight can
// be planned because the world is not metric.
//
// What changed since the last iteration (photos gone or replaced, the database, options) is said in
// messages; too little room on the disk for the next iteration is an Error. The caller holds the
// workspace's SessionLock. `observer` may be null.
SessionSummary RunSession(const SessionInputs& inputs, const StageOptions& options,
                          const JobControl& job, SessionObserver* observer = nullptr);

}  // namespace colmap_ext
