// state.json: where a session stands.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

struct SessionState {
  std::string source;       // what the photos come from: "scene church", "photos <folder>", …
  int iterations_done = 0;  // complete, on disk
  int next_view_id = 0;
  std::string finished;  // why the session ended; empty while it goes on
  // Fixed at the first iteration.
  std::optional<RegionOfInterest> region;
  std::optional<double> site_gsd_mm;  // see SessionOptions::fit_to_site
};

// Throws Error naming the file for anything that is not a state of this version.
SessionState ReadSessionState(const std::filesystem::path& path);
void WriteSessionState(const SessionState& state, const std::filesystem::path& path);

}  // namespace colmap_ext
