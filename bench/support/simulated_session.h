// Sessions over simulated scenes, for what is measured on them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Runs `colmap_ext active_capture <arguments>` in `workspace`, with the renderer in the place of a
// flight, unless the session there has ended; one that was stopped goes on. Output goes to
// <workspace>.log. Throws Error when it fails.
SessionSummary RunSimulatedSession(const std::filesystem::path& workspace,
                                   const std::vector<std::string>& arguments,
                                   const JobControl& job);

}  // namespace colmap_ext
