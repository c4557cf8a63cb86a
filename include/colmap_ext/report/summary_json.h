// summary.json.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

// {"finished", "iterations": [{"photos", "registered", "covered_ratio", "reachable_covered_ratio",
// "planned_views", "mean_error_m", "rms_error_m", "completeness": {"25.4mm": …}, "wall_s",
// "stage_wall_s": {…}, "unregistered": […]}]}. What is unknown is left out. Written atomically.
Json SummaryToJson(const SessionSummary& summary);
void WriteSummary(const SessionSummary& summary, const std::filesystem::path& path);
// Comes back exactly. Only "photos", "registered" and "wall_s" must be there. Throws Error naming
// the file and JSON pointer of what is missing or wrong.
SessionSummary ReadSummary(const std::filesystem::path& path);

// timing.json: wall seconds of each stage. Throws Error as above.
std::map<std::string, double> ReadStageSeconds(const std::filesystem::path& path);

}  // namespace colmap_ext
