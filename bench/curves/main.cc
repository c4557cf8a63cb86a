// bench_curves: error and completeness of the model after every iteration of active sessions that
// differ in one thing: the planner, a stage left out, the rule of coverage, the noise of GPS, the
// size of the photos. bench/plot_curves.py draws what this writes.
#include <iostream>

#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/text.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "support/session_curves.h"
#include "support/simulated_session.h"
#include "variants.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  fs::path work = "bench_curves_work";
  fs::path results = "bench/results";
  std::string scenes = "church,boxes,gate";
  fs::path scene_path;
  std::string preset;
  std::string variants = "planners";
  std::string seeds = "1";
  int first_views = 64;
  int max_photos = 108;

  std::string Check() const {
    if (first_views < 4) return "--first_views must be at least 4";
    if (max_photos < first_views) return "--max_photos must be at least --first_views";
    return "";
  }
};

struct Scene {
  std::string name;
  std::vector<std::string> arguments;  // that make active_capture simulate it
};

std::vector<Scene> ScenesOf(const BenchOptions& options) {
  std::vector<Scene> scenes;
  for (const std::string& name : SplitAtCommas(options.scenes)) {
    scenes.push_back({name, {"--scene", name}});
  }
  if (!options.scene_path.empty()) {
    RequireFile(options.scene_path, "scene model");
    scenes.push_back(
        {options.scene_path.stem().string(), {"--scene_path", options.scene_path.string()}});
  }
  if (scenes.empty()) throw UsageError("give --scenes, --scene_path or both");
  if (!options.preset.empty()) {
    for (Scene& scene : scenes) {
      scene.arguments.insert(scene.arguments.end(), {"--preset", options.preset});
    }
  }
  return scenes;
}

// It goes on when all is covered: curves end at equal photos.
SessionSummary FlySession(const Scene& scene, const Variant& variant, const std::string& seed,
                          const BenchOptions& options, const JobControl& job) {
  std::vector<std::string> arguments{"--Session.pictures",
                                     "0",
                                     "--Session.max_iterations",
                                     "50",
                                     "--Session.max_photos",
                                     std::to_string(options.max_photos),
                                     "--Session.target_covered_ratio",
                                     "1",
                                     "--InitialFlight.num_views",
                                     std::to_string(options.first_views),
                                     "--Simulation.seed",
                                     seed};
  arguments.insert(arguments.end(), scene.arguments.begin(), scene.arguments.end());
  arguments.insert(arguments.end(), variant.arguments.begin(), variant.arguments.end());
  return RunSimulatedSession(options.work / scene.name / ("seed_" + seed) / variant.name, arguments,
                             job);
}

// The last row of every curve: what each variant came to.
std::string EndTable(const std::string& title,
                     const std::vector<std::pair<Variant, SessionSummary>>& sessions) {
  std::string text = "### " + title + ": in the end\n\n" +
                     CurveHeader("session", sessions.front().second.iterations.back());
  for (const auto& [variant, summary] : sessions) {
    text += CurveRow(variant.name + ": " + variant.what, summary.iterations.back());
  }
  return text + "\n";
}

// {"scene", "seed", "variant", "what", "summary": as summary.json}.
Json CurveJson(const Scene& scene, const std::string& seed, const Variant& variant,
               const SessionSummary& summary) {
  return {{"scene", scene.name},
          {"seed", seed},
          {"variant", variant.name},
          {"what", variant.what},
          {"summary", SummaryToJson(summary)}};
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  set.Add("", "work_path", &options.work, "folder for the sessions (kept, and gone on with)");
  set.Add("", "results", &options.results, "folder for curves.json");
  set.Add("", "scenes", &options.scenes, "church, boxes, gate, with commas; empty: none");
  set.Add("", "scene_path", &options.scene_path, "any textured model (OBJ, glTF, COLLADA)");
  set.Add("", "preset", &options.preset, "outdoor or indoor; empty: as suits the scene");
  set.Add("", "variants", &options.variants,
          "planners, stereo, coverage, gps, width, all, or names of sessions, with commas");
  set.Add("", "seeds", &options.seeds, "of ground, noise and positions, with commas");
  set.Add("", "first_views", &options.first_views, "photos of the first flight");
  set.Add("", "max_photos", &options.max_photos, "photos at which a session ends");
  if (!ReadCommandLine(arguments, &set)) return 0;
  ThrowIfInvalid(options.Check());
  const std::vector<Variant> variants = VariantsOf(options.variants);
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  Json curves = Json::array();
  std::string tables;
  for (const Scene& scene : ScenesOf(options)) {
    for (const std::string& seed : SplitAtCommas(options.seeds)) {
      const std::string title = scene.name + ", seed " + seed;
      std::vector<std::pair<Variant, SessionSummary>> sessions;
      for (const Variant& variant : variants) {
        const SessionSummary summary = FlySession(scene, variant, seed, options, job);
        const std::string table = CurveTable(title + ", " + variant.name, summary);
        std::cout << table << std::flush;
        tables += table;
        curves.push_back(CurveJson(scene, seed, variant, summary));
        sessions.emplace_back(variant, summary);
      }
      const std::string end = EndTable(title, sessions);
      std::cout << end << std::flush;
      tables += end;
    }
  }
  fs::create_directories(options.results);
  WriteFileAtomically(options.results / "curves.json", curves.dump(1) + "\n");
  WriteFileAtomically(options.results / "curves.md", tables);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_curves", argc, argv, colmap_ext::Run);
}
