// What a session reports about each of its iterations: summary.json, the table on the terminal, the
// page.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace colmap_ext {

// Completeness at one distance. `key`: as in the evaluation file, "25.4mm".
struct CompletenessValue {
  std::string key;
  double share = 0;  // 0 … 1
};

struct IterationSummary {
  int photos = 0;                       // taken so far
  int registered = 0;                   // of them
  std::optional<double> covered_ratio;  // 0 … 1; absent: coverage was not reached
  // The same without the uncovered iso-points that no view in free space could see well.
  std::optional<double> reachable_covered_ratio;
  int planned_views = 0;               // of the path that was planned next
  std::optional<double> mean_error_m;  // against the truth; absent without truth
  std::optional<double> rms_error_m;
  std::vector<CompletenessValue> completeness;  // ascending distance; empty without truth
  double wall_s = 0;                            // of the whole iteration
  std::map<std::string, double> stage_wall_s;  // "sparse", "superpixels", … (DESIGN: timing.json)
  std::vector<std::string> unregistered;       // names of the photos without a pose, sorted
};

struct SessionSummary {
  // Why it ended: "covered", "view_limit", "iteration_limit", "nothing_reachable"; empty: it has
  // not ended.
  std::string finished;
  std::vector<IterationSummary> iterations;  // [i]: iterations/NNN with NNN = i
};

// A sentence for people; `finished` itself when it is none of the known reasons.
std::string FinishedSentence(const std::string& finished);

// Stages in the order in which they run; unknown ones follow, sorted.
std::vector<std::string> StagesOf(const SessionSummary& summary);

}  // namespace colmap_ext
