// bench_dense: the built-in dense reconstruction of a simulated first flight, against the truth and
// beside the fast model.
#include <atomic>
#include <thread>

#include "colmap_ext/eval/count_views.h"
#include "colmap_ext/eval/error_colors.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/text.h"
#include "support/bench_main.h"
#include "support/bench_program.h"
#include "support/bench_report.h"
#include "support/evaluated_model.h"
#include "survey.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  fs::path work = "bench_dense_work";
  fs::path results = "bench/results";
  int num_views = 64;
  std::string widths = "960,1920";
  std::string poses = "true,sfm";
  bool kill_test = true;
};

EvaluatedModel Evaluate(const fs::path& mesh, const fs::path& sparse, bool true_poses,
                        const BenchSurvey& survey, const JobControl& job) {
  return EvaluateAgainst(survey.truth, mesh, sparse, survey.true_poses, !true_poses, job);
}

// The model, and the truth coloured by its distance to the model (yellow: 100 mm and more).
void Paint(const EvaluatedModel& measured, const fs::path& mesh, const BenchSurvey& survey,
           const fs::path& path_stem) {
  const ColoredMesh colored = ReadColoredMesh(mesh);
  const TriangleMesh& model = measured.aligned;
  const MeshPainter painter(model);
  const auto errors = ErrorColors(DistancesTo(survey.truth, model.vertices), 0.1);
  for (const double yaw_deg : {30.0, 210.0}) {
    const PictureCamera camera =
        FitCamera(BoundsOf(survey.truth), {DegToRad(yaw_deg), DegToRad(-25)}, {1400, 1000});
    const std::string view = "_" + std::to_string(static_cast<int>(yaw_deg)) + ".png";
    WritePng(painter.Render(VertexColors(model, colored.color), camera).bgr,
             path_stem.string() + "_model" + view);
    WritePng(painter.Render(VertexColors(model, errors), camera).bgr,
             path_stem.string() + "_error" + view);
  }
}

std::vector<std::string> DenseArguments(const BenchSurvey& survey, const fs::path& sparse,
                                        const FastModel& fast, const std::string& width,
                                        const fs::path& output) {
  return {"dense_reconstructor",
          "--backend",
          "builtin",
          "--input_path",
          sparse.string(),
          "--image_path",
          survey.images_full.string(),
          "--prior_path",
          fast.dense.string(),
          "--output_path",
          output.string(),
          "--DenseStereo.max_width_px",
          width};
}

// Adds the rows of one model and returns its mean error over what two photos saw.
double AddErrors(const std::string& name, const EvaluatedModel& measured, bool has_goals,
                 BenchReport* report) {
  const ErrorSummary& seen = *measured.result.seen;
  report->Add(name + ": mean error, seen by two photos", 1000 * seen.mean_m, "mm");
  report->Add(name + ": median error, seen by two photos", 1000 * seen.median_m, "mm");
  report->Add(name + ": mean error, all of the truth", 1000 * measured.result.errors.mean_m, "mm");
  report->Add(name + ": within 1 inch, seen by two photos", 100 * seen.completeness.at(0), "%",
              has_goals ? std::optional(AtLeast(60)) : std::nullopt);
  report->Add(name + ": within 2 inch, seen by two photos", 100 * seen.completeness.at(1), "%",
              has_goals ? std::optional(AtLeast(90)) : std::nullopt);
  report->Add(name + ": model within 1 inch of the truth",
              100 * measured.result.scores.at(0).accuracy, "%");
  return seen.mean_m;
}

void RunModels(const BenchOptions& options, const BenchSurvey& survey, const std::string& poses,
               const JobControl& job, BenchReport* report) {
  const bool true_poses = poses == "true";
  const fs::path sparse = true_poses ? survey.true_sparse : survey.sfm_sparse;
  const fs::path folder = options.work / (poses + "_poses");
  const FastModel fast = MakeFastModel(survey, sparse, folder / "fast", job);
  const std::string label = poses + " poses, ";
  const EvaluatedModel measured_fast = Evaluate(fast.mesh, sparse, true_poses, survey, job);
  const double fast_error = AddErrors(label + "fast model", measured_fast, false, report);
  report->Add(label + "fast model: CPU", fast.cpu_s, "CPU s");
  Paint(measured_fast, fast.mesh, survey, options.work / (poses + "_fast"));
  for (const std::string& width : SplitAtCommas(options.widths)) {
    const fs::path output = folder / ("dense_" + width);
    fs::remove_all(output);
    const ChildProcessResult run = RunColmapExt(DenseArguments(survey, sparse, fast, width, output),
                                                folder / ("dense_" + width + ".log"), job);
    const EvaluatedModel measured =
        Evaluate(output / "surface.ply", sparse, true_poses, survey, job);
    const std::string name = label + "builtin, width " + width;
    const double error = AddErrors(name, measured, width == "1920", report);
    report->Add(name + ": mean error by the fast model's", error / fast_error, "ratio",
                AtMost(1.0 / 3));
    report->Add(name + ": wall a photo", run.wall_s / options.num_views, "s");
    report->Add(name + ": CPU a photo", run.cpu_s / options.num_views, "CPU s");
    report->Add(name + ": peak memory", run.peak_mib, "MiB", AtMost(8192));
    Paint(measured, output / "surface.ply", survey, options.work / (poses + "_" + width));
  }
}

std::size_t NumFiles(const fs::path& folder) {
  std::error_code ignored;
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    count += entry.is_regular_file();
  return count;
}

// Kills (SIGKILL) a run when half of the depth maps are there, starts it again, and compares.
void RunKillTest(const BenchOptions& options, const BenchSurvey& survey, const JobControl& job,
                 BenchReport* report) {
  const std::string width = "480";
  const fs::path folder = options.work / "kill";
  fs::remove_all(folder);
  const FastModel no_prior{"", survey.images_low.parent_path() / "iterations" / "000" / "sparse",
                           0};
  const auto arguments = [&](const std::string& name) {
    return DenseArguments(survey, survey.sfm_sparse, no_prior, width, folder / name);
  };
  const ChildProcessResult whole = RunColmapExt(arguments("whole"), folder / "whole.log", job);
  std::atomic<bool> kill = false;
  std::jthread watcher([&](const std::stop_token& stop) {
    while (!stop.stop_requested() && !kill) {
      kill =
          NumFiles(folder / "killed" / "builtin") > static_cast<std::size_t>(options.num_views) / 2;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  try {
    RunColmapExt(arguments("killed"), folder / "killed.log", JobControl(nullptr, &kill));
    throw Error("the run ended before it could be killed");
  } catch (const CancelledError&) {
  }
  const std::size_t there = NumFiles(folder / "killed" / "builtin") - 1;
  const ChildProcessResult rest = RunColmapExt(arguments("killed"), folder / "killed.log", job);
  bool is_same = true;
  for (const char* file : {"fused.ply", "surface.ply"}) {
    is_same = is_same && ReadFile(folder / "whole" / file) == ReadFile(folder / "killed" / file);
  }
  report->Add("killed: depth maps that were there", static_cast<double>(there), "photos");
  report->Add("killed and started again: CPU of the rest by that of a whole run",
              rest.cpu_s / whole.cpu_s, "ratio", AtMost(0.9));
  report->Add("killed and started again: same bytes (1 yes)", is_same ? 1 : 0, "", AtLeast(1));
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  set.Add("", "work_path", &options.work, "folder for photos (kept) and models");
  set.Add("", "results", &options.results, "folder for dense.json");
  set.Add("", "num_views", &options.num_views, "photos of the flight");
  set.Add("", "widths", &options.widths, "of the photos that are matched, px");
  set.Add("", "poses", &options.poses, "true, sfm or both");
  set.Add("", "kill_test", &options.kill_test, "whether a killed run is tried (0 or 1)");
  if (!ReadCommandLine(arguments, &set)) return 0;
  ConsoleSink sink(LogLevel::kWarning);
  const JobControl job(&sink, nullptr);
  const BenchSurvey survey = MakeSurvey(options.work, options.num_views, job);
  BenchReport report("dense");
  for (const std::string& poses : SplitAtCommas(options.poses)) {
    RunModels(options, survey, poses, job, &report);
  }
  if (options.kill_test) RunKillTest(options, survey, job, &report);
  PrintAndWrite(report, options.results);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_dense", argc, argv, colmap_ext::Run);
}
