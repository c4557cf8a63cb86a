// bench_coverage: whether what the coverage map calls uncovered is what a dense reconstruction from
// the same photos gets wrong, and whether its predicted error is the true one.
#include <algorithm>

#include "calibration.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/text.h"
#include "flights.h"
#include "judged.h"
#include "measures.h"
#include "pictures.h"
#include "points_table.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "support/flown_site.h"
#include "timing.h"

namespace colmap_ext {
namespace {

constexpr double kNoPairMm = 1e6;

struct BenchOptions {
  std::filesystem::path work_path = "bench_coverage_work";
  SiteOptions site;
  CoverageOptions coverage;
  std::filesystem::path results = "bench/results";
  std::filesystem::path pictures;
  std::filesystem::path points;
  std::string scenes = "church,boxes,gate";
  std::string flights = "poor,middling,good";
  double bad_mm = 50.8;  // 2 inches, the paper's threshold
  bool calibrate = false, times = true;
};

// The judged points of one or more flights, as columns.
struct Columns {
  std::vector<bool> is_bad, is_flagged, is_flagged_by_paper;
  std::vector<double> doubt, predicted_mm, true_mm, spacing, scanner_doubt, few_views;
  // Of the places of the truth.
  std::vector<bool> is_bad_place, is_flagged_place;
  std::vector<double> doubt_of_place;

  void Add(const JudgedFlight& judged, double bad_mm) {
    for (const JudgedPoint& judged_point : judged.points) {
      const IsoPoint& point = judged_point.point;
      is_bad.push_back(1000 * judged_point.true_error_m > bad_mm);
      is_flagged.push_back(point.coverage == CoverageClass::kUncovered);
      is_flagged_by_paper.push_back(judged_point.paper == CoverageClass::kUncovered);
      doubt.push_back(1 - point.score);
      predicted_mm.push_back(point.predicted_error_mm < 0 ? kNoPairMm : point.predicted_error_mm);
      true_mm.push_back(1000 * judged_point.true_error_m);
      spacing.push_back(judged_point.cloud.spacing_m);
      scanner_doubt.push_back(-judged_point.cloud.ScannerConfidence());
      few_views.push_back(-judged_point.cues.num_views);
    }
    for (const JudgedPlace& place : judged.places) {
      is_bad_place.push_back(1000 * place.error_m > bad_mm);
      is_flagged_place.push_back(!place.is_covered);
      doubt_of_place.push_back(1 - place.score);
    }
  }
};

double ShareOf(const std::vector<bool>& flags) {
  return static_cast<double>(std::count(flags.begin(), flags.end(), true)) /
         static_cast<double>(std::max<std::size_t>(1, flags.size()));
}

using Goal = std::optional<BenchGoal>;

void ReportFlags(const std::string& name, const PrecisionRecall& flags, const Goal& goal,
                 BenchReport* report) {
  report->Add(name + ": precision of uncovered", flags.precision, "", goal);
  report->Add(name + ": recall of uncovered", flags.recall, "", goal);
}

void ReportColumns(const std::string& name, const Columns& columns, bool has_goals,
                   BenchReport* report) {
  const auto goal = [&](double value) { return has_goals ? Goal(AtLeast(value)) : std::nullopt; };
  report->Add(name + ": iso-points judged", static_cast<double>(columns.is_bad.size()), "");
  report->Add(name + ": share that is bad", ShareOf(columns.is_bad), "");
  report->Add(name + ": AUC of uncovered", AreaUnderCurve(columns.doubt, columns.is_bad), "",
              goal(0.9));
  report->Add(name + ": AUC by predicted error alone",
              AreaUnderCurve(columns.predicted_mm, columns.is_bad), "");
  report->Add(name + ": AUC by point density", AreaUnderCurve(columns.spacing, columns.is_bad), "");
  report->Add(name + ": AUC by density and smoothness",
              AreaUnderCurve(columns.scanner_doubt, columns.is_bad), "");
  report->Add(name + ": AUC by count of views", AreaUnderCurve(columns.few_views, columns.is_bad),
              "");
  ReportFlags(name, MeasureFlags(columns.is_flagged, columns.is_bad), goal(0.8), report);
  report->Add(name + ": rank correlation of predicted and true error",
              RankCorrelation(columns.predicted_mm, columns.true_mm), "", goal(0.7));
}

// The same asked the other way round: is what the truth has at a place called covered there?
void ReportPlaces(const std::string& scene, const Columns& columns, BenchReport* report) {
  const std::string name = scene + ", places of the truth";
  report->Add(name + ": share that is bad", ShareOf(columns.is_bad_place), "");
  report->Add(name + ": AUC of not covered",
              AreaUnderCurve(columns.doubt_of_place, columns.is_bad_place), "");
  ReportFlags(name, MeasureFlags(columns.is_flagged_place, columns.is_bad_place), std::nullopt,
              report);
  ReportFlags(name + ", score at its best", BestFlags(columns.doubt_of_place, columns.is_bad_place),
              std::nullopt, report);
}

// The other rules, with the thresholds that suit them best in hindsight; the paper's with its own.
void ReportRivals(const std::string& name, const Columns& columns, BenchReport* report) {
  ReportFlags(name + ", score at its best", BestFlags(columns.doubt, columns.is_bad), std::nullopt,
              report);
  ReportFlags(name + ", point density at its best", BestFlags(columns.spacing, columns.is_bad),
              std::nullopt, report);
  ReportFlags(name + ", density and smoothness at its best",
              BestFlags(columns.scanner_doubt, columns.is_bad), std::nullopt, report);
  ReportFlags(name + ", count of views at its best", BestFlags(columns.few_views, columns.is_bad),
              std::nullopt, report);
  ReportFlags(name + ", the paper's classes",
              MeasureFlags(columns.is_flagged_by_paper, columns.is_bad), std::nullopt, report);
}

void ReportCalibration(const std::string& name, const Columns& columns, BenchReport* report) {
  constexpr std::size_t kMinPoints = 100;
  const std::vector<double> edges = {5, 10, 15, 22, 32, 46, 68, 100};
  for (const CalibrationBin& bin : CalibrationCurve(columns.predicted_mm, columns.true_mm, edges)) {
    if (bin.points < kMinPoints) continue;
    const std::string row = name + ": predicted " + std::to_string(std::lround(bin.low)) + " to " +
                            std::to_string(std::lround(bin.high)) + " mm, " +
                            std::to_string(bin.points) + " points: true by predicted";
    const double ratio = bin.measured / bin.predicted;
    report->Add(row, ratio, "ratio", ratio > 1 ? AtMost(1.3) : AtLeast(0.7));
  }
}

void RunScene(const std::string& scene, const BenchOptions& options, const JobControl& job,
              Columns* everything, std::vector<JudgedFlight>* flights, BenchReport* report) {
  const Site site = MakeSite(scene, options.site);
  Columns of_scene;
  FlightModels models;
  for (const std::string& quality : SplitAtCommas(options.flights)) {
    models = MakeFlightModels(site, FlightOf(quality, site.model, site.is_indoor()),
                              options.work_path / scene / quality, options.site, job);
    JudgedFlight judged = Judge(site, models, options.coverage, job);
    const std::string name = scene + ", " + quality;
    Columns of_flight;
    of_flight.Add(judged, options.bad_mm);
    of_scene.Add(judged, options.bad_mm);
    everything->Add(judged, options.bad_mm);
    report->Add(name + ": photos", models.num_views, "");
    report->Add(name + ": iso-points far from the truth", judged.FarShare(), "");
    report->Add(name + ": truth without iso-point near", judged.unrepresented, "");
    ReportColumns(name, of_flight, false, report);
    if (!options.pictures.empty()) {
      const std::filesystem::path stem = options.pictures / (scene + "_" + quality);
      PaintVerdicts(judged, models.surface, 0.001 * options.bad_mm, stem);
      PaintComparison(judged, models.surface, 0.001 * options.bad_mm, stem);
    }
    if (!options.points.empty()) {
      WritePointsTable(judged, options.points / (scene + "_" + quality + ".csv"));
    }
    flights->push_back(std::move(judged));
  }
  ReportColumns(scene, of_scene, true, report);
  ReportPlaces(scene, of_scene, report);
  ReportRivals(scene, of_scene, report);
  ReportCalibration(scene, of_scene, report);
  if (options.times) MeasureTimes(scene, site, models, options.coverage, report, job);
}

// The constants from all flights, and how each scene fares with those of the others alone.
void Calibrate(const std::vector<std::string>& scenes,
               const std::vector<std::vector<JudgedFlight>>& flights, const BenchOptions& options,
               BenchReport* report) {
  const ErrorModel& model = options.coverage.error_model;
  std::vector<JudgedFlight> all;
  for (const auto& of_scene : flights) all.insert(all.end(), of_scene.begin(), of_scene.end());
  ReportErrorModel("fitted to all", FitErrorModel(all, model), report);
  if (scenes.size() < 2) return;
  for (std::size_t left_out = 0; left_out < scenes.size(); ++left_out) {
    std::vector<JudgedFlight> others;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      if (i != left_out) others.insert(others.end(), flights[i].begin(), flights[i].end());
    }
    const ErrorModel fitted = FitErrorModel(others, model);
    Columns columns;
    for (JudgedFlight flight : flights[left_out]) {
      for (JudgedPoint& point : flight.points) {
        point.point.predicted_error_mm = PredictErrorMm(point.cues, fitted);
        point.point.score = ProbabilityWithin(options.bad_mm, point.point.predicted_error_mm,
                                              FailureProbability(point.around, fitted), fitted);
        point.point.coverage = point.point.score >= options.coverage.min_score
                                   ? CoverageClass::kCovered
                                   : CoverageClass::kUncovered;
      }
      columns.Add(flight, options.bad_mm);
    }
    const std::string name = scenes[left_out] + ", constants of the other scenes";
    ReportErrorModel(name, fitted, report);
    ReportColumns(name, columns, false, report);
    ReportCalibration(name, columns, report);
  }
}

void AddOptions(BenchOptions* options, OptionSet* set) {
  set->Add("", "work_path", &options->work_path, "folder for photos and models, made once");
  set->Add("", "texel_scale", &options->site.texel_scale, "above 1: coarser, quicker textures");
  set->Add("", "dense_width", &options->site.dense_width_px, "of the dense model's photos, px");
  set->Add("", "true_poses", &options->site.true_poses, "1: true poses; 0: of sparse_updater");
  set->Add("", "results", &options->results, "folder for coverage.json");
  set->Add("", "pictures", &options->pictures, "folder for pictures of the verdicts; empty: none");
  set->Add("", "points", &options->points, "folder for the judged points as CSV; empty: none");
  set->Add("", "scenes", &options->scenes, "of church, boxes, gate");
  set->Add("", "flights", &options->flights, "of poor, middling, good");
  set->Add(
      "", "calibrate", &options->calibrate,
      "also fit the constants of the predicted error: to all, and without each scene (0 or 1)");
  set->Add("", "times", &options->times, "also race colmap poisson_mesher (0 or 1)");
  BindOptions(*set, &options->coverage);
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  AddOptions(&options, &set);
  if (!ReadCommandLine(arguments, &set)) return 0;
  if (!set.IsSet("Coverage.target_error_mm")) options.coverage.target_error_mm = options.bad_mm;
  ThrowIfInvalid(options.coverage.Check());
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  BenchReport report("coverage");
  Columns everything;
  const std::vector<std::string> scenes = SplitAtCommas(options.scenes);
  std::vector<std::vector<JudgedFlight>> flights(scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    RunScene(scenes[i], options, job, &everything, &flights[i], &report);
  }
  ReportColumns("all", everything, true, &report);
  ReportPlaces("all", everything, &report);
  ReportCalibration("all", everything, &report);
  if (options.calibrate) Calibrate(scenes, flights, options, &report);
  PrintAndWrite(report, options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_coverage", argc, argv, colmap_ext::Run);
}
