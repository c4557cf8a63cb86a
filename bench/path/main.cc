// The safety campaign: random sites, every accepted path looked at by an independent sampler at
// 1 cm.
#include <iostream>

#include "colmap_ext/util/options.h"
#include "colmap_ext/util/stage_timer.h"
#include "safety_campaign.h"
#include "support/bench_main.h"
#include "support/bench_report.h"

namespace colmap_ext {
namespace {

int Run(const std::vector<std::string>& arguments) {
  int count = 1000;
  int first_seed = 1;
  std::filesystem::path results = "bench/results";
  OptionSet set;
  set.Add("", "sites", &count, "random sites");
  set.Add("", "first_seed", &first_seed, "seed of the first one");
  set.Add("", "results", &results, "folder for path.json");
  if (!ReadCommandLine(arguments, &set)) return 0;
  const StageTimer timer;
  const SafetyFindings f = RunSafetyCampaign(static_cast<std::uint64_t>(first_seed), count);
  const StageCost cost = timer.Stop();
  BenchReport report("path");
  report.Add("random sites", f.sites, "sites");
  report.Add("views flown", f.flown_views, "views");
  report.Add("views dropped, each with its reason", f.dropped_views, "views");
  report.Add("views lost without a reason", f.unnamed_drops, "views", AtMost(0));
  report.Add("sites without any safe way, said so", f.sites_without_way, "sites");
  report.Add("starts refused", f.refused_starts, "sites");
  report.Add("starts inside obstacles accepted", f.accepted_bad_starts, "sites", AtMost(0));
  report.Add("path examined", f.length_m / 1000, "km");
  report.Add("places examined (1 cm)", static_cast<double>(f.samples) / 1e6, "million");
  report.Add("places nearer than the safe distance", static_cast<double>(f.too_near), "places",
             AtMost(0));
  report.Add("places in unknown space", static_cast<double>(f.unknown), "places", AtMost(0));
  report.Add("places beyond fence or in no-fly zone", static_cast<double>(f.outside), "places",
             AtMost(0));
  report.Add("least spare distance", 1000 * f.least_spare_m, "mm", AtLeast(0));
  report.Add("proved clearance above the sampled one", 1000 * f.overstated_clearance_m, "mm",
             AtMost(0.1));
  report.Add("sites that came within 10 cm of something unseen", f.near_unseen, "sites");
  report.Add("CPU", cost.cpu_s, "s");
  report.Add("wall", cost.wall_s, "s");
  report.Write(results);
  const std::string complaint = f.Complaint();
  if (!complaint.empty()) std::cerr << "bench_path: " << complaint << '\n';
  return complaint.empty() ? 0 : 1;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_path", argc, argv, colmap_ext::Run);
}
