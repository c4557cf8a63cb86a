// The fast linear MVS against `colmap feature_extractor` on the same photos: CPU and wall seconds a
// stage, memory, linearity, and whether the number of threads changes the result.

#include <sys/resource.h>
#include <tbb/global_control.h>

#include <iostream>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/stage_timer.h"
#include "colmap_ext/util/text.h"
#include "support/bench_main.h"
#include "support/bench_report.h"
#include "survey.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct Settings {
  SurveySpec survey;
  std::string counts = "81";  // comma separated
  fs::path cache = "bench/cache";
  fs::path results = "bench/results";
  bool real_sfm = false;
  bool yardstick = true;
  bool threads = false;
  int cores = 2;
  SuperpixelOptions superpixels;
  SuperpixelStereoOptions stereo;
  PointSamplerOptions points;
};

struct Run {
  StageCost load;
  SuperpixelStereoResult stereo;
  StageCost sampling;
  StageCost all;
  std::size_t points = 0;
};

Run RunMvs(const fs::path& model_path, const fs::path& images, const Settings& settings) {
  Run run;
  const StageTimer all;
  const Reconstruction model = ReadReconstruction(model_path);
  const StageTimer load;
  const PhotoSet photos = LoadPhotoSet(model, images.string(), true);
  run.load = load.Stop();
  run.stereo = RunSuperpixelStereo(photos, settings.superpixels, settings.stereo, JobControl());
  const StageTimer sampling;
  run.points = SamplePoints(photos, run.stereo.views, run.stereo.neighbors, settings.points).size();
  run.sampling = sampling.Stop();
  run.all = all.Stop();
  return run;
}

// CPU seconds that COLMAP's feature extraction takes with 2 threads on the CPU.
double YardstickCpu(const fs::path& images, const fs::path& folder, const JobControl& job) {
  const fs::path database = folder / "yardstick.db";
  fs::remove(database);
  ChildProcessOptions options;
  options.arguments = {"colmap",
                       "feature_extractor",
                       "--database_path",
                       database.string(),
                       "--image_path",
                       images.string(),
                       "--ImageReader.single_camera",
                       "1",
                       "--SiftExtraction.use_gpu",
                       "0",
                       "--SiftExtraction.num_threads",
                       "2",
                       "--SiftExtraction.first_octave",
                       "0"};
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}, {"OMP_WAIT_POLICY", "passive"}};
  const ChildProcessResult result = RunChildProcess(options, job);
  if (result.exit_code != 0) throw Error("colmap feature_extractor failed:\n" + result.output);
  fs::remove(database);
  return result.cpu_s;
}

void AddStage(const std::string& name, const StageCost& cost, int photos, BenchReport* report) {
  report->Add(name + ", CPU", 1000 * cost.cpu_s / photos, "ms a photo");
  report->Add(name + ", wall", 1000 * cost.wall_s / photos, "ms a photo");
}

void ReportRun(const Run& run, const std::string& label, const Settings& settings, int photos,
               BenchReport* report) {
  AddStage(label + "decode", run.load, photos, report);
  AddStage(label + "superpixels", run.stereo.superpixels, photos, report);
  AddStage(label + "stereo", run.stereo.stereo, photos, report);
  AddStage(label + "photometric", run.stereo.photometric, photos, report);
  AddStage(label + "fusion", run.stereo.fusion, photos, report);
  AddStage(label + "points", run.sampling, photos, report);
  AddStage(label + "all", run.all, photos, report);
  report->Add(label + "photos a second", photos / run.all.wall_s, "1/s");
  report->Add(label + "cores busy", 100 * run.all.cpu_s / (run.all.wall_s * settings.cores), "%",
              AtLeast(85));
  report->Add(label + "points", static_cast<double>(run.points), "");
}

double ConfidentShare(const std::vector<ViewMesh>& views, double min_confidence) {
  double all = 0;
  double confident = 0;
  for (const ViewMesh& view : views) {
    for (const float confidence : view.confidence) {
      all += 1;
      confident += confidence > min_confidence;
    }
  }
  return all > 0 ? confident / all : 0;
}

bool SameBytes(const SuperpixelStereoResult& a, const SuperpixelStereoResult& b) {
  bool same = a.views.size() == b.views.size() && a.neighbors == b.neighbors;
  for (std::size_t i = 0; same && i < a.views.size(); ++i) {
    same = a.views[i].inverse_depth == b.views[i].inverse_depth &&
           a.views[i].confidence == b.views[i].confidence &&
           a.views[i].supported == b.views[i].supported &&
           a.views[i].image.vertices_px == b.views[i].image.vertices_px;
  }
  return same;
}

void CheckThreads(const fs::path& model_path, const fs::path& images, const Settings& settings,
                  BenchReport* report) {
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return RunMvs(model_path, images, settings).stereo;
  };
  const SuperpixelStereoResult one = run(1);
  for (const std::size_t threads : {2, 8}) {
    report->Add("same bytes, 1 and " + std::to_string(threads) + " threads",
                SameBytes(one, run(threads)) ? 1 : 0, "", AtLeast(1));
  }
}

std::vector<int> ParseCounts(const std::string& text) {
  std::vector<int> counts;
  for (const std::string& word : SplitAtCommas(text)) {
    const int count = std::atoi(word.c_str());
    if (count < 3) throw UsageError("--counts: '" + word + "' is not a number from 3 on");
    counts.push_back(count);
  }
  if (counts.empty()) throw UsageError("--counts is empty");
  return counts;
}

fs::path CacheOf(const SurveySpec& spec, const Settings& settings) {
  return settings.cache / (spec.scene + "_" + std::to_string(spec.photos) + "_" +
                           std::to_string(spec.width) + "x" + std::to_string(spec.height));
}

void Bench(const Settings& settings, const JobControl& job) {
  BenchReport report("mvs");
  double first_cpu_ms = 0;
  for (const int photos : ParseCounts(settings.counts)) {
    SurveySpec spec = settings.survey;
    spec.photos = photos;
    const fs::path cache = CacheOf(spec, settings);
    const Survey survey = PrepareSurvey(spec, cache, job);
    const fs::path model =
        settings.real_sfm ? PrepareRealSfm(survey, cache, job) : survey.true_model;
    const bool is_first = first_cpu_ms == 0;
    const std::string label = std::to_string(photos) + " photos: ";
    const Run run = RunMvs(model, survey.images, settings);
    ReportRun(run, label, settings, photos, &report);
    report.Add(label + "confident facets",
               100 * ConfidentShare(run.stereo.views, settings.points.min_confidence), "%");
    const double cpu_ms = 1000 * run.all.cpu_s / photos;
    if (is_first) {
      first_cpu_ms = cpu_ms;
      report.Add(label + "peak memory", run.all.peak_mib, "MiB", AtMost(1024));
    } else {
      report.Add(label + "peak memory", run.all.peak_mib, "MiB");
      report.Add(label + "CPU a photo, against the first count", cpu_ms / first_cpu_ms, "ratio",
                 AtMost(1.15));
    }
    if (is_first && settings.yardstick) {
      const double yardstick_ms = 1000 * YardstickCpu(survey.images, cache, job) / photos;
      report.Add(label + "colmap feature_extractor, CPU", yardstick_ms, "ms a photo");
      report.Add(label + "all against feature_extractor, CPU", cpu_ms / yardstick_ms, "ratio",
                 AtMost(1.0));
    }
    if (is_first && settings.threads) CheckThreads(model, survey.images, settings, &report);
  }
  report.Write(settings.results);
}

int Run(const std::vector<std::string>& arguments) {
  Settings settings;
  OptionSet options;
  options.Add("", "scene", &settings.survey.scene, "church, boxes or gate");
  options.Add("", "counts", &settings.counts, "numbers of photos, separated by commas");
  options.Add("", "width", &settings.survey.width, "of the photos (px)");
  options.Add("", "height", &settings.survey.height, "of the photos (px)");
  options.Add("", "texel_scale", &settings.survey.texel_scale, "of the scene's textures");
  options.Add("", "cache_path", &settings.cache, "folder that keeps rendered photos");
  options.Add("", "results_path", &settings.results, "folder for mvs.json");
  options.Add("", "real_sfm", &settings.real_sfm, "poses and points by COLMAP, not simulated");
  options.Add("", "yardstick", &settings.yardstick, "run colmap feature_extractor as well");
  options.Add("", "threads", &settings.threads, "compare 1, 2 and 8 threads");
  options.Add("", "cores", &settings.cores, "cores of this machine");
  BindOptions(options, &settings.superpixels);
  BindOptions(options, &settings.stereo);
  BindOptions(options, &settings.points);
  options.Parse(arguments);
  if (options.HelpRequested()) {
    std::cout << "bench_mvs: speed and memory of the fast linear MVS\n" << options.HelpText();
    return 0;
  }
  ConsoleSink sink(LogLevel::kInfo);
  Bench(settings, JobControl(&sink, nullptr));
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_mvs", argc, argv, colmap_ext::Run);
}
