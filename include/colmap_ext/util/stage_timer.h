// What a stage cost.
#pragma once

#include <map>
#include <string>

namespace colmap_ext {

struct StageCost {
  double wall_s = 0;
  double cpu_s = 0;     // user + system of this process and of children that ended
  double peak_mib = 0;  // maximum resident set of this process so far
};

// Measures from construction to Stop().
class StageTimer {
 public:
  StageTimer();
  StageCost Stop() const;

 private:
  StageCost start_;
};

// JSON text of timing.json: {"<stage>": {"wall_s": …, "cpu_s": …, "peak_mib": …}, …}
std::string StageCostsToJson(const std::map<std::string, StageCost>& cost_of_stage);

}  // namespace colmap_ext
