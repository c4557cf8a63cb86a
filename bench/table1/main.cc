// bench_table1: the paper's Table 1. Our active plans and the five manual plans, simulated,
// reconstructed in the same way and compared with the truth; and what each iteration of the active
// plan gained. Everything is kept below --work_path: a run that was stopped goes on.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/text.h"
#include "pictures.h"
#include "plans.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "support/evaluated_model.h"
#include "support/session_curves.h"
#include "table.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct ManualCount {
  const char* pattern;
  int num_views;  // paper
};
constexpr ManualCount kManualPlans[] = {{"grid-downward", 143},
                                        {"grid-multi-angle", 858},
                                        {"2-circles", 105},
                                        {"rectangle-sparse", 130},
                                        {"rectangle-dense", 390}};

// Terms of a manual plan with the paper's number of photos, or the share of it that was asked for.
constexpr const char* kOwnCount = "own count";

struct BenchOptions {
  fs::path work = "bench_table1_work";
  fs::path results = "bench/results";
  std::string scenes = "church";
  std::string strategies = "submodular,plane_sweep";
  std::string plans = "grid-downward,grid-multi-angle,2-circles,rectangle-sparse,rectangle-dense";
  std::string seeds = "1,2,3";
  int width = 1920;
  double texel_scale = 1;
  double photo_share = 1;
  bool equal_terms = true;
  bool quick = false;

  std::string Check() const {
    if (width < 320 || width > 4096) return "--width must be in 320 … 4096";
    if (!(texel_scale >= 1)) return "--texel_scale must be at least 1";
    if (!(photo_share > 0 && photo_share <= 1)) return "--photo_share must be in ]0, 1]";
    return "";
  }
  int Share(int photos) const {
    return std::max(4, static_cast<int>(std::lround(photo_share * photos)));
  }
};

// A scene with one seed: what its plans are flown over and judged against.
struct Ground {
  Site site;
  TriangleMesh object;  // without ground
  SiteOptions options;
  fs::path folder;
};

Ground MakeGround(const std::string& scene, std::uint64_t seed, const BenchOptions& options) {
  Ground ground;
  ground.options = {seed, options.texel_scale, options.width, false};
  ground.site = MakeSite(scene, ground.options);
  ground.object = MakeScene(scene, seed, options.texel_scale).Truth().model;
  ground.folder = options.work / scene / ("seed_" + std::to_string(seed));
  return ground;
}

struct JudgedPlan {
  PlanRow row;
  TriangleMesh mesh;
};

JudgedPlan Judge(const Ground& ground, const FlownPlan& plan, const std::string& terms,
                 const JobControl& job) {
  const fs::path folder = ground.folder / (plan.name + "_" + std::to_string(plan.views.size()) +
                                           "_" + std::to_string(ground.options.dense_width_px));
  const FlightModels models =
      MakeFlightModels(ground.site, plan.views, folder, ground.options, job);
  EvaluatedModel evaluated = EvaluateAgainst(ground.object, models.dense_surface, models.sparse,
                                             models.true_poses, true, job);
  const auto registered = ReadReconstruction(models.sparse).images.size();
  JudgedPlan judged{RowOf(plan.name, terms, models.num_views, static_cast<int>(registered),
                          MetresOf(plan.views), evaluated.result),
                    std::move(evaluated.aligned)};
  std::cout << TableOf(ground.site.name + ", " + terms, {judged.row}) << std::flush;
  return judged;
}

// Rows by plan and terms, one a seed; the models of the first seed for the picture.
struct SceneResults {
  std::vector<std::pair<std::string, std::vector<PlanRow>>> rows;
  std::vector<ModelToPaint> models;
  std::string curves;

  void Add(JudgedPlan judged, bool is_first_seed) {
    const std::string key = judged.row.plan + "/" + judged.row.terms;
    auto found = std::find_if(rows.begin(), rows.end(), [&](auto& r) { return r.first == key; });
    if (found == rows.end()) found = rows.insert(rows.end(), {key, {}});
    found->second.push_back(judged.row);
    if (!is_first_seed) return;
    models.push_back({judged.row.plan + ", " + FormatNumber("%.0f photos", judged.row.photos),
                      std::move(judged.mesh)});
  }
  std::vector<PlanRow> Means() const {
    std::vector<PlanRow> means;
    for (const auto& [key, of_seeds] : rows) means.push_back(MeanOf(of_seeds));
    return means;
  }
};

void RunSeed(const Ground& ground, bool is_first_seed, const BenchOptions& options,
             const JobControl& job, SceneResults* results) {
  int active_photos = 0;
  double active_metres = 0;
  for (const std::string& strategy : SplitAtCommas(options.strategies)) {
    const ActiveSession session{strategy, options.Share(64), options.Share(108), options.Share(12),
                                ground.options.scene_seed};
    const fs::path workspace = ground.folder / ("session_" + strategy);
    const FlownPlan plan = ActivePlan(ground.site, session, workspace, job);
    results->Add(Judge(ground, plan, "active", job), is_first_seed);
    if (active_photos == 0) {
      active_photos = static_cast<int>(plan.views.size());
      active_metres = MetresOf(plan.views);
    }
    if (is_first_seed) {
      results->curves += CurveTable(ground.site.name + ", " + strategy,
                                    ReadSummary(Workspace(workspace).summary_json()));
    }
  }
  for (const ManualCount& manual : kManualPlans) {
    const auto wanted = SplitAtCommas(options.plans);
    if (std::find(wanted.begin(), wanted.end(), manual.pattern) == wanted.end()) continue;
    const FlownPlan plan = ManualPlan(ground.site, manual.pattern, options.Share(manual.num_views));
    results->Add(Judge(ground, plan, kOwnCount, job), is_first_seed);
    if (!options.equal_terms) continue;
    results->Add(
        Judge(ground, ManualPlan(ground.site, manual.pattern, active_photos), "equal photos", job),
        false);
    const FlownPlan trimmed = TrimmedTo(plan, active_metres);
    if (trimmed.views.size() == plan.views.size()) continue;  // the paper's count is no longer
    results->Add(Judge(ground, trimmed, "equal metres", job), false);
  }
}

// The goals compare the first active plan with rectangle-dense and with every manual plan.
void ReportGoals(const std::string& scene, const std::vector<PlanRow>& rows, BenchReport* report) {
  const PlanRow& ours = rows.front();
  double best_error = 0;
  const PlanRow* dense = nullptr;
  for (const PlanRow& row : rows) {
    if (row.terms != kOwnCount) continue;
    if (best_error == 0 || row.mean_error_m < best_error) best_error = row.mean_error_m;
    if (row.plan == "rectangle-dense") dense = &row;
  }
  if (best_error > 0) {
    report->Add(scene + ": mean error by that of the best manual plan",
                ours.mean_error_m / best_error, "ratio", AtMost(1));
  }
  if (dense == nullptr) return;
  report->Add(scene + ": within 1 inch by rectangle-dense's",
              ours.within_1_inch / dense->within_1_inch, "ratio", AtLeast(1.25));
  report->Add(scene + ": within 2 inch by rectangle-dense's",
              ours.within_2_inch / dense->within_2_inch, "ratio", AtLeast(1));
}

void AddOptions(OptionSet* set, BenchOptions* options) {
  set->Add("", "work_path", &options->work, "folder for sessions, photos and models (kept)");
  set->Add("", "results", &options->results, "folder for table1.json");
  set->Add("", "scenes", &options->scenes, "church, boxes, gate, with commas");
  set->Add("", "strategies", &options->strategies, "of the active plans; the first one has goals");
  set->Add("", "plans", &options->plans, "manual plans, with commas; empty: none");
  set->Add("", "seeds", &options->seeds, "of ground, noise and positions, with commas");
  set->Add("", "width", &options->width, "of the photos for the dense models [px]");
  set->Add("", "texel_scale", &options->texel_scale, "coarser textures than the scene's own, >= 1");
  set->Add("", "photo_share", &options->photo_share, "part of the counts of all plans ]0, 1]");
  set->Add(
      "", "equal_terms", &options->equal_terms,
      "manual plans also with as many photos, and with as many metres, as the first active one");
  set->Add(
      "", "quick", &options->quick,
      "reduced form: one seed, a third of the photos, 640 px, no grid-multi-angle, the paper's "
      "counts only; options that are given win");
}

void ApplyQuick(const OptionSet& set, BenchOptions* options) {
  if (!set.IsSet("seeds")) options->seeds = "1";
  if (!set.IsSet("photo_share")) options->photo_share = 1.0 / 3;
  if (!set.IsSet("width")) options->width = 640;
  if (!set.IsSet("texel_scale")) options->texel_scale = 2;
  if (!set.IsSet("equal_terms")) options->equal_terms = false;
  if (!set.IsSet("plans"))
    options->plans = "grid-downward,2-circles,rectangle-sparse,rectangle-dense";
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  AddOptions(&set, &options);
  if (!ReadCommandLine(arguments, &set)) return 0;
  if (options.quick) ApplyQuick(set, &options);
  ThrowIfInvalid(options.Check());
  const auto begin = std::chrono::steady_clock::now();
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  BenchReport report("table1");
  std::string tables;
  for (const std::string& scene : SplitAtCommas(options.scenes)) {
    SceneResults results;
    bool is_first_seed = true;
    TriangleMesh truth;
    for (const std::string& seed : SplitAtCommas(options.seeds)) {
      const Ground ground = MakeGround(scene, std::stoull(seed), options);
      if (is_first_seed) truth = ground.object;
      RunSeed(ground, is_first_seed, options, job, &results);
      is_first_seed = false;
    }
    const std::vector<PlanRow> means = results.Means();
    tables += TableOf(scene, means) + results.curves;
    ReportGoals(scene, means, &report);
    PaintSideBySide(truth, results.models, 0.1, 4, options.work / (scene + ".png"));
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  report.Add("wall, of what was not there yet", wall.count() / 60, "min");
  std::cout << tables << report.ToMarkdown();
  WriteFileAtomically(options.work / "table1.md", tables + report.ToMarkdown());
  report.Write(options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_table1", argc, argv, colmap_ext::Run);
}
