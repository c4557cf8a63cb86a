#include "colmap_ext/report/summary.h"

#include <algorithm>
#include <array>
#include <set>

namespace colmap_ext {

std::string FinishedSentence(const std::string& finished) {
  if (finished.empty()) return "The session has not ended yet.";
  if (finished == "covered") return "Finished: what can be reached is covered.";
  if (finished == "view_limit") return "Stopped: the limit of photos is reached.";
  if (finished == "iteration_limit") return "Stopped: the limit of iterations is reached.";
  if (finished == "nothing_reachable") {
    return "Stopped: what is still uncovered cannot be reached by a safe flight.";
  }
  return "Stopped: " + finished + ".";
}

std::vector<std::string> StagesOf(const SessionSummary& summary) {
  static const std::array<const char*, 9> kOrder = {
      "sparse", "superpixels", "stereo", "fusion", "surface", "coverage", "nbv", "path", "capture"};
  std::set<std::string> present;
  for (const IterationSummary& iteration : summary.iterations) {
    for (const auto& [stage, seconds] : iteration.stage_wall_s) present.insert(stage);
  }
  std::vector<std::string> stages;
  for (const char* stage : kOrder) {
    if (present.erase(stage) > 0) stages.emplace_back(stage);
  }
  stages.insert(stages.end(), present.begin(), present.end());
  return stages;
}

}  // namespace colmap_ext
