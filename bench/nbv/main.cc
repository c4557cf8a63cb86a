// bench_nbv: next best views: time of a plan, and what the strategies need to cover a model.
#include <algorithm>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>

#include "closed_loop.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"
#include "speed.h"
#include "support/bench_main.h"
#include "support/bench_report.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  std::string scenes = "church,boxes,gate";
  std::string strategies = "plane_sweep,submodular,random,next_farthest_point";
  std::string loop = "geometry";
  int num_seeds = 3;
  int max_photos = 300;
  bool ask_reach = true;
  bool speed = true;
  int repetitions = 5;
  fs::path workspace;
  fs::path work = "bench_nbv_work";
  std::string photo_options = "";
  fs::path results = "bench/results";
};

const std::vector<double> kShares = {0.90, 0.95, 0.99};

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    if (!part.empty()) parts.push_back(part);
  }
  return parts;
}

// The first step with so many points covered; null: it was never reached.
const LoopStep* FirstWith(const LoopResult& result, double covered) {
  for (const LoopStep& step : result.steps) {
    if (static_cast<double>(step.covered) >= covered) return &step;
  }
  return nullptr;
}

struct SeedRun {
  LoopResult result;
  double coverable = 0;
};

// `coverable`: points that can be covered; the loop on the model ends a little beyond the largest
// share that is asked for.
std::vector<LoopResult> RunStrategies(const BenchOptions& options, const TrueSite& site,
                                      double coverable, const std::vector<std::string>& strategies,
                                      const JobControl& job) {
  const auto wanted = static_cast<std::size_t>((kShares.back() + 0.002) * coverable);
  const std::string seed = std::to_string(site.options().nbv.seed);
  std::vector<LoopResult> results;
  for (const std::string& strategy : strategies) {
    if (options.loop == "photos") {
      const fs::path workspace = options.work / (site.scene() + "_" + strategy + "_" + seed);
      fs::create_directories(workspace);
      results.push_back(RunPhotoLoop(site, strategy, options.max_photos,
                                     Split(options.photo_options, ' '), workspace, job));
    } else {
      results.push_back(
          RunGeometryLoop(site, strategy, wanted, options.max_photos, options.ask_reach, job));
    }
    const LoopResult& last = results.back();
    std::cerr << site.scene() << ", " << strategy << ", seed " << seed << ": "
              << 100 * static_cast<double>(last.steps.back().covered) / coverable << " % by "
              << last.steps.back().photos << " photos, " << last.iterations << " plans in "
              << last.planning_s << " s, " << last.dropped << " views dropped; " << last.stop_reason
              << '\n';
  }
  return results;
}

// Medians over the seeds; a seed that never gets there counts as more than any other.
void ReportShare(const std::string& name, const std::vector<SeedRun>& runs, double share,
                 std::map<double, double>* photos_for, BenchReport* report) {
  std::vector<double> photos, metres, seconds;
  int reached = 0;
  for (const SeedRun& run : runs) {
    const LoopStep* step = FirstWith(run.result, share * run.coverable);
    const bool is_reached = step != nullptr;
    reached += is_reached ? 1 : 0;
    photos.push_back(is_reached ? step->photos : std::numeric_limits<double>::max());
    metres.push_back(is_reached ? step->length_m : std::numeric_limits<double>::max());
    seconds.push_back(is_reached ? step->duration_s : std::numeric_limits<double>::max());
  }
  const std::string what = name + ": " + std::to_string(std::lround(100 * share)) + " %";
  report->Add(what + ", runs that get there", reached, "of " + std::to_string(runs.size()));
  if (2 * static_cast<std::size_t>(reached) <= runs.size()) return;
  (*photos_for)[share] = MiddleValue(photos);
  report->Add(what + ", photos", MiddleValue(photos), "");
  report->Add(what + ", length of flight", MiddleValue(metres), "m");
  report->Add(what + ", time of flight", MiddleValue(seconds), "s");
}

void ReportRatio(const std::string& scene, double first_photos,
                 std::map<std::string, std::map<double, double>>* photos_for, BenchReport* report) {
  for (const double share : kShares) {
    auto& sweep = (*photos_for)["plane_sweep"];
    auto& submodular = (*photos_for)["submodular"];
    if (!sweep.contains(share) || !submodular.contains(share)) continue;
    const std::string what = scene + ": photos of submodular to plane_sweep, " +
                             std::to_string(std::lround(100 * share)) + " %";
    const auto goal = share == 0.95 ? std::optional(AtMost(0.8)) : std::nullopt;
    report->Add(what, submodular[share] / sweep[share], "ratio", goal);
    report->Add(what + ", first flight counted",
                (first_photos + submodular[share]) / (first_photos + sweep[share]), "ratio");
  }
}

void RunLoops(const BenchOptions& options, const std::string& scene, const OptionSet& set,
              const StageOptions& stages, const JobControl& job, BenchReport* report) {
  const std::vector<std::string> strategies = Split(options.strategies, ',');
  std::map<std::string, std::vector<SeedRun>> runs;
  for (int seed = 1; seed <= options.num_seeds; ++seed) {
    const auto number = static_cast<std::uint64_t>(seed);
    const TrueSite site(scene, number, OptionsFor(scene, set, stages));
    auto coverable = static_cast<double>(site.CountCoverable(site.FirstFlight()));
    const std::vector<LoopResult> results =
        RunStrategies(options, site, coverable, strategies, job);
    // What some strategy covered can be covered, too.
    for (const LoopResult& result : results) {
      coverable = std::max(coverable, static_cast<double>(result.steps.back().covered));
    }
    for (std::size_t i = 0; i < strategies.size(); ++i) {
      runs[strategies[i]].push_back({results[i], coverable});
    }
  }
  std::map<std::string, std::map<double, double>> photos_for;
  const double first_photos = runs.begin()->second.front().result.first_photos;
  report->Add(scene + ": photos of the first flight", first_photos, "");
  for (const std::string& strategy : strategies) {
    const std::string name = scene + ", " + strategy + ", loop of " + options.loop;
    int planned = 0, registered = 0, dropped = 0;
    std::vector<double> ends;
    for (const SeedRun& run : runs[strategy]) {
      planned += run.result.planned;
      registered += run.result.registered;
      dropped += run.result.dropped;
      ends.push_back(static_cast<double>(run.result.steps.back().covered) / run.coverable);
    }
    for (const double share : kShares) {
      ReportShare(name, runs[strategy], share, &photos_for[strategy], report);
    }
    report->Add(name + ": covered in the end", 100 * MiddleValue(ends), "%");
    if (planned + dropped > 0) {
      report->Add(name + ": planned views that no path was found to",
                  100.0 * dropped / (planned + dropped), "%");
    }
    if (options.loop == "photos" && planned > 0) {
      report->Add(name + ": planned photos that registered", 100.0 * registered / planned, "%",
                  AtLeast(99));
    }
  }
  ReportRatio(scene, first_photos, &photos_for, report);
}

void AddOptions(BenchOptions* o, StageOptions* stages, OptionSet* set) {
  set->Add("", "scenes", &o->scenes, "of church, boxes, gate, with commas between");
  set->Add("", "strategies", &o->strategies, "with commas between");
  set->Add("", "loop", &o->loop,
           "geometry: planning sees the true mesh, nothing is rendered; photos: the whole of "
           "active_capture; none");
  set->Add("", "seeds", &o->num_seeds, "runs of each strategy and scene");
  set->Add("", "max_photos", &o->max_photos, "planned photos of a run at most");
  set->Add("", "ask_reach", &o->ask_reach,
           "loop of geometry: views are only chosen where a way leads (0 or 1)");
  set->Add("", "speed", &o->speed, "measure times and rays (0 or 1)");
  set->Add("", "repetitions", &o->repetitions, "of each time; the best counts");
  set->Add("", "workspace_path", &o->workspace,
           "times on the newest iteration of this session of the church; empty: the true church");
  set->Add("", "work_path", &o->work, "folder of the sessions of --loop photos");
  set->Add("", "photo_options", &o->photo_options,
           "more options of active_capture, with spaces between");
  set->Add("", "results", &o->results, "folder of nbv.json");
  BindOptions(*set, stages);
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  StageOptions stages;
  OptionSet set;
  AddOptions(&options, &stages, &set);
  if (!ReadCommandLine(arguments, &set)) return 0;
  if (options.loop != "geometry" && options.loop != "photos" && options.loop != "none") {
    throw UsageError("--loop must be geometry, photos or none");
  }
  ThrowIfInvalid(stages.Check());
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  BenchReport report("nbv");
  if (options.speed) {
    const TrueSite church("church", 1, OptionsFor("church", set, stages));
    MeasureSpeed(church, options.workspace, options.repetitions, &report);
    MeasureRays(church, &report);
  }
  if (options.loop != "none") {
    for (const std::string& scene : Split(options.scenes, ',')) {
      RunLoops(options, scene, set, stages, job, &report);
    }
  }
  PrintAndWrite(report, options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_nbv", argc, argv, colmap_ext::Run);
}
