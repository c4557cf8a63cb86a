// bench_online: one iteration of a session, from new photos to the path of the next flight, on top
// of more and more photos: what it costs a photo, and where the time goes.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/text.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "support/simulated_session.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  fs::path work = "bench_online_work";
  fs::path results = "bench/results";
  std::string scene = "church";
  std::string counts = "64,256,1024";
  int new_photos = 8;
  int iterations = 3;
  double keep_tolerance_px = SuperpixelStereoOptions().keep_tolerance_px;

  std::string Check() const {
    if (new_photos < 1 || new_photos > 1000) return "--new_photos must be in 1 … 1000";
    if (iterations < 1 || iterations > 100) return "--iterations must be in 1 … 100";
    return "";
  }
};

// From photos to path.
constexpr const char* kStages[] = {"sparse",  "superpixels", "stereo", "fusion",
                                   "surface", "coverage",    "nbv",    "path"};
// The rest of an iteration is the simulator's.
constexpr const char* kOfSimulation[] = {"capture", "evaluation"};

// Wall time of an iteration without what is the simulator's.
double OwnWallSeconds(const IterationSummary& iteration) {
  double seconds = iteration.wall_s;
  for (const char* stage : kOfSimulation) {
    const auto cost = iteration.stage_wall_s.find(stage);
    if (cost != iteration.stage_wall_s.end()) seconds -= cost->second;
  }
  return seconds;
}

struct StageTime {
  double wall_s = 0, cpu_s = 0;  // of a new photo
};

// A session whose first flight takes `count` photos, then `iterations` times some more.
fs::path FlySession(int count, const BenchOptions& options, const JobControl& job) {
  const fs::path workspace = options.work / (options.scene + "_" + std::to_string(count));
  RunSimulatedSession(
      workspace,
      {"--scene", options.scene, "--Session.pictures", "0", "--Session.max_iterations",
       std::to_string(1 + options.iterations), "--Session.max_photos", "100000",
       "--Session.target_covered_ratio", "1", "--InitialFlight.num_views", std::to_string(count),
       "--NextBestView.num_views", std::to_string(options.new_photos),
       "--SuperpixelStereo.keep_tolerance_px", std::to_string(options.keep_tolerance_px)},
      job);
  return workspace;
}

// Of every iteration after the first flight; "total": wall time of all of it, CPU time of the
// stages.
std::map<std::string, std::vector<StageTime>> TimesOf(const fs::path& workspace) {
  const SessionSummary summary = ReadSummary(Workspace(workspace).summary_json());
  std::map<std::string, std::vector<StageTime>> times;
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    const int new_photos = summary.iterations[i].photos - summary.iterations[i - 1].photos;
    if (new_photos <= 0) continue;
    const IterationFiles files{Workspace(workspace).iteration(static_cast<int>(i))};
    const auto cost = nlohmann::json::parse(ReadFile(files.timing_json()));
    StageTime total{OwnWallSeconds(summary.iterations[i]) / new_photos, 0};
    for (const char* stage : kStages) {
      if (!cost.contains(stage)) continue;
      const StageTime time{cost[stage]["wall_s"].get<double>() / new_photos,
                           cost[stage]["cpu_s"].get<double>() / new_photos};
      times[stage].push_back(time);
      total.cpu_s += time.cpu_s;
    }
    times["total"].push_back(total);
  }
  if (times.empty()) throw Error(workspace.string() + ": the session took no photos to measure");
  return times;
}

StageTime MedianOf(const std::vector<StageTime>& times) {
  std::vector<double> wall, cpu;
  for (const StageTime& time : times) {
    wall.push_back(time.wall_s);
    cpu.push_back(time.cpu_s);
  }
  return {Median(wall), Median(cpu)};
}

void ReportCount(int count, const std::map<std::string, std::vector<StageTime>>& times,
                 BenchReport* report) {
  const std::string name = std::to_string(count) + " photos, ";
  for (const char* stage : kStages) {
    if (!times.contains(stage)) continue;
    const StageTime time = MedianOf(times.at(stage));
    report->Add(name + stage, time.wall_s, "s a new photo");
    report->Add(name + stage + ", CPU", time.cpu_s, "CPU s a new photo");
  }
  const StageTime total = MedianOf(times.at("total"));
  report->Add(name + "photos in to path out", total.wall_s, "s a new photo", AtMost(1));
  report->Add(name + "photos in to path out, CPU", total.cpu_s, "CPU s a new photo");
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  set.Add("", "work_path", &options.work, "folder for the sessions; one that is there is read");
  set.Add("", "results", &options.results, "folder for online.json");
  set.Add("", "scene", &options.scene, "church, boxes or gate");
  set.Add("", "counts", &options.counts, "photos of the first flight, with commas");
  set.Add("", "new_photos", &options.new_photos, "photos of each later flight");
  set.Add("", "iterations", &options.iterations, "later flights; medians are reported");
  set.Add("", "keep_tolerance_px", &options.keep_tolerance_px,
          "of the session's stereo; 0: every photo is solved in every iteration");
  if (!ReadCommandLine(arguments, &set)) return 0;
  ThrowIfInvalid(options.Check());
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  BenchReport report("online");
  std::vector<double> totals;
  for (const std::string& count : SplitAtCommas(options.counts)) {
    const auto times = TimesOf(FlySession(std::stoi(count), options, job));
    ReportCount(std::stoi(count), times, &report);
    totals.push_back(MedianOf(times.at("total")).cpu_s);
  }
  if (totals.size() > 1) {
    report.Add("CPU of the last by that of the first", totals.back() / totals.front(), "ratio",
               AtMost(1.2));
  }
  PrintAndWrite(report, options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_online", argc, argv, colmap_ext::Run);
}
