// bench_mvs_accuracy: superpixel stereo against rendered truth, part by part.

#include "calibration.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/options.h"
#include "measures.h"
#include "partition.h"
#include "pictures.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "survey.h"

namespace colmap_ext {
namespace {

struct BenchOptions {
  SurveyOptions survey;
  std::string variants = "all";
  bool calibrate = false;
  int step = 2;
  std::filesystem::path results = "bench/results";
  std::filesystem::path pictures;
  int picture_every = 10;
  SuperpixelOptions superpixels;
  SuperpixelStereoOptions stereo;
};

struct Variant {
  std::string name;
  SuperpixelStereoOptions stereo;
  bool has_goals = false;
};

std::vector<Variant> MakeVariants(const BenchOptions& options) {
  std::vector<Variant> variants{{"full", options.stereo, true}};
  if (options.variants == "full") return variants;
  Variant no_photometric{"without photometric", options.stereo, false};
  no_photometric.stereo.photometric = false;
  Variant no_fusion{"without fusion", options.stereo, false};
  no_fusion.stereo.fusion_passes = 0;
  Variant neither{"without both", options.stereo, false};
  neither.stereo.fusion_passes = 0;
  neither.stereo.photometric = false;
  // Vertices shared: differences at them cost so much that none stays.
  Variant continuous{"C0, without both", neither.stereo, false};
  continuous.stereo.continuity_weight = 1e5;
  variants.insert(variants.end(), {no_photometric, no_fusion, neither, continuous});
  return variants;
}

void ReportAccuracy(const std::string& name, const AccuracyFigures& figures, bool has_goals,
                    BenchReport* report) {
  const auto goal = [&](const BenchGoal& g) {
    return has_goals ? std::optional<BenchGoal>(g) : std::nullopt;
  };
  report->Add(name + ": pixels with confidence > 0.5", 100 * figures.share_confident, "%",
              goal(AtLeast(70)));
  report->Add(name + ": median error there", 100 * figures.median, "%", goal(AtMost(0.3)));
  report->Add(name + ": 90th percentile there", 100 * figures.p90, "%", goal(AtMost(2)));
  report->Add(name + ": more than 5 % wrong there", 100 * figures.share_wrong, "%");
  report->Add(name + ": confident and within 1 %", 100 * figures.share_accurate, "%");
  report->Add(name + ": supported pixels", 100 * figures.share_supported, "%");
  report->Add(name + ": median error, supported", 100 * figures.median_supported, "%");
  report->Add(name + ": 90th percentile, supported", 100 * figures.p90_supported, "%");
  report->Add(name + ": tenths of confidence whose mean error rises", figures.rising_deciles, "",
              goal(AtMost(0)));
}

void ReportDeciles(const std::string& name, const AccuracyFigures& figures, BenchReport* report) {
  for (std::size_t d = 0; d < figures.decile_error.size(); ++d) {
    report->Add(name + ": mean error of tenth " + std::to_string(d + 1) + ", confidence to " +
                    std::to_string(figures.decile_confidence[d]).substr(0, 5),
                100 * figures.decile_error[d], "%");
  }
}

void RunVariant(const Variant& variant, const Survey& survey, const BenchOptions& options,
                const JobControl& job, BenchReport* report) {
  const SuperpixelStereoResult result =
      RunSuperpixelStereo(survey.photos, options.superpixels, variant.stereo, job);
  const std::string name = options.survey.scene + ", " + variant.name;
  const AccuracyFigures figures =
      MeasureAccuracy(result.views, survey.truth, Pixels::kModel, options.step);
  ReportAccuracy(name, figures, variant.has_goals, report);
  const AccuracyFigures all =
      MeasureAccuracy(result.views, survey.truth, Pixels::kAllSurfaces, options.step);
  ReportAccuracy(name + ", with ground", all, false, report);
  const EdgeFigures edges = MeasureDepthEdges(result.views, survey.truth);
  report->Add(name + ": depth edges recalled", 100 * edges.recall, "%");
  report->Add(name + ": depth edges that are true", 100 * edges.precision, "%");
  report->Add(name + ": superpixels", result.superpixels.cpu_s, "CPU s");
  report->Add(name + ": initial solve", result.stereo.cpu_s, "CPU s");
  report->Add(name + ": photometric stage", result.photometric.cpu_s, "CPU s");
  report->Add(name + ": fusion", result.fusion.cpu_s, "CPU s");
  if (!variant.has_goals) return;
  ReportDeciles(name, figures, report);
  if (options.calibrate) ReportCalibration(survey, result, variant.stereo, report);
  if (!options.pictures.empty()) {
    WriteErrorPictures(survey, result.views, options.picture_every, options.pictures);
  }
}

void AddOptions(BenchOptions* o, OptionSet* set) {
  set->Add("", "scene", &o->survey.scene, "church, boxes or gate");
  set->Add("", "num_photos", &o->survey.num_photos, "photos on three rings");
  set->Add("", "texel_scale", &o->survey.texel_scale, "above 1: coarser, quicker textures");
  set->Add("", "sfm_poses", &o->survey.sfm_poses, "poses of colmap's mapper; 0: the true ones");
  set->Add("", "cache", &o->survey.cache, "folder of photos, truth and model, made once");
  set->Add("", "colmap_path", &o->survey.colmap_path, "the colmap program");
  set->Add("", "variants", &o->variants,
           "all; full: only the complete method; none: the partition only");
  set->Add("", "calibrate", &o->calibrate, "also fit the sigmas of the confidence (0 or 1)");
  set->Add("", "step", &o->step, "every so many-th pixel counts, in both directions");
  set->Add("", "results", &o->results, "folder of mvs_accuracy_<scene>.json");
  set->Add("", "pictures", &o->pictures, "folder of error pictures; empty: none");
  set->Add("", "picture_every", &o->picture_every, "of every so many-th photo");
  BindOptions(*set, &o->superpixels);
  BindOptions(*set, &o->stereo);
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  AddOptions(&options, &set);
  if (!ReadCommandLine(arguments, &set)) return 0;
  if (options.survey.cache.empty()) throw UsageError("--cache is required");
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  const Survey survey = MakeSurvey(options.survey, job);
  BenchReport report("mvs_accuracy_" + options.survey.scene);
  report.Add(options.survey.scene + ": photos", static_cast<double>(survey.photos.photos.size()),
             "");
  constexpr int kPartitionEvery = 8;
  ReportPartition(options.survey.scene, survey, options.superpixels, kPartitionEvery, &report);
  if (options.variants == "none") {
    report.Write(options.results);
    return 0;
  }
  for (const Variant& variant : MakeVariants(options)) {
    RunVariant(variant, survey, options, JobControl(), &report);
  }
  report.Write(options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_mvs_accuracy", argc, argv, colmap_ext::Run);
}
