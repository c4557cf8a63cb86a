#include "colmap_ext/util/stage_timer.h"

#include <sys/resource.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "util/seconds_of.h"

namespace colmap_ext {
namespace {

StageCost Now() {
  rusage self{};
  rusage children{};
  getrusage(RUSAGE_SELF, &self);
  getrusage(RUSAGE_CHILDREN, &children);
  StageCost cost;
  const auto since_epoch = std::chrono::steady_clock::now().time_since_epoch();
  cost.wall_s = std::chrono::duration<double>(since_epoch).count();
  cost.cpu_s = SecondsOf(self.ru_utime) + SecondsOf(self.ru_stime) + SecondsOf(children.ru_utime) +
               SecondsOf(children.ru_stime);
  cost.peak_mib = static_cast<double>(self.ru_maxrss) / 1024.0;  // Linux counts in KiB
  return cost;
}

}  // namespace

StageTimer::StageTimer() : start_(Now()) {}

StageCost StageTimer::Stop() const {
  StageCost cost = Now();
  cost.wall_s -= start_.wall_s;
  cost.cpu_s -= start_.cpu_s;
  return cost;
}

std::string StageCostsToJson(const std::map<std::string, StageCost>& cost_of_stage) {
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [stage, cost] : cost_of_stage) {
    json[stage] = {{"wall_s", cost.wall_s}, {"cpu_s", cost.cpu_s}, {"peak_mib", cost.peak_mib}};
  }
  return json.dump(2) + "\n";
}

}  // namespace colmap_ext
