// What a session has done, and what it would do next, without doing it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/session/session.h"

namespace colmap_ext {

// What `active_capture --status` shows.
struct SessionStatus {
  std::filesystem::path workspace_path;
  std::string source;                // "scene church", "photos <folder>"
  std::optional<int> process;        // that works on it now; 0: unknown
  bool was_interrupted = false;      // and nobody works on it now
  SessionSummary summary;            // of the iterations that are done
  std::optional<double> length_m;    // of the path that comes next, when there is one
  std::optional<double> duration_s;  // of its flight
};

// Reads the workspace and writes nothing. Throws Error when there is no session.
SessionStatus ReadSessionStatus(const std::filesystem::path& workspace_path);
std::string StatusText(const SessionStatus& status);
Json StatusToJson(const SessionStatus& status);

// What `active_capture --dry_run` shows.
struct SessionForecast {
  std::string source;
  int iteration = 0;                // that comes next: 0, 1, …
  std::string nothing_to_do;        // why; empty: there is something to do
  std::vector<std::string> stages;  // in order
  int photos_before = 0;
  int new_photos = 0;
  std::optional<double> flight_length_m;  // of a session that flies
  std::optional<double> flight_duration_s;
  // Of the stages, from what the last iteration took; nullopt at the first one.
  std::optional<double> work_s;
  std::uint64_t disk_next_bytes = 0;     // of this iteration
  std::uint64_t disk_session_bytes = 0;  // until the session's limits
  std::uint64_t disk_free_bytes = 0;
  std::vector<std::string> changes;  // of photos, database and options since the last iteration
};

// Reads, and makes the scene of a simulation's first flight; writes nothing. Throws as RunSession.
SessionForecast ForecastSession(const SessionInputs& inputs, const StageOptions& options);
std::string ForecastText(const SessionForecast& forecast);
Json ForecastToJson(const SessionForecast& forecast);

}  // namespace colmap_ext
