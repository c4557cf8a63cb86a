// sparse_updater beside plain COLMAP: a first model, then updates of a few photos. See --help.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "colmap_ext/eval/alignment.h"
#include "colmap_ext/scene/database.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/util/error.h"
#include "flight.h"
#include "matcher_race.h"
#include "rivals.h"
#include "support/bench_main.h"
#include "support/bench_report.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  fs::path work_path;
  fs::path results_path = "bench/results";
  int photos = 64, updates = 5, batch = 8;
  int curve_to = 0;
  int plain_neighbors = 0;
  int noise_seeds = 3;
  bool plain = true, noise = true, matchers = true;
  double texel_scale = 1;
  double noise_m = 1.5;
};

void Bind(OptionSet& set, BenchOptions* options) {
  set.Add("", "work_path", &options->work_path, "folder for photos (kept) and projects; required");
  set.Add("", "results_path", &options->results_path, "folder for sfm.json");
  set.Add("", "photos", &options->photos, "photos of the first model");
  set.Add("", "updates", &options->updates, "how many updates follow");
  set.Add("", "batch", &options->batch, "photos of an update");
  set.Add("", "curve_to", &options->curve_to,
          "our updates go on until the model has so many photos (0: no)");
  set.Add("", "plain_neighbors", &options->plain_neighbors,
          "spatial_matcher's max_num_neighbors (0: COLMAP's default)");
  set.Add("", "plain", &options->plain, "run plain COLMAP beside ours (0 or 1)");
  set.Add("", "noise", &options->noise, "also with GPS noise (0 or 1)");
  set.Add("", "matchers", &options->matchers, "compare descriptor matchers (0 or 1)");
  set.Add("", "noise_seeds", &options->noise_seeds, "how many times, each with other noise");
  set.Add("", "noise_m", &options->noise_m, "sigma of that noise on each axis (m)");
  set.Add("", "texel_scale", &options->texel_scale, "coarser textures (0.5 ... 16)");
}

double MeanErrorPx(const Reconstruction& model) {
  double sum = 0, count = 0;
  for (const auto& [id, point] : model.points) {
    sum += point.error_px * static_cast<double>(point.track.size());
    count += static_cast<double>(point.track.size());
  }
  return count == 0 ? 0 : sum / count;
}

double Observations(const Reconstruction& model) {
  double count = 0;
  for (const auto& [id, point] : model.points) count += static_cast<double>(point.track.size());
  return count;
}

// A project of ours that grows: its photos are links in a folder of its own.
class OurProject {
 public:
  OurProject(fs::path folder, const Flight& flight, const fs::path& photos, const Camera& camera,
             const SparseUpdateOptions& options)
      : folder_(std::move(folder)), photos_(photos), flight_(flight), options_(options) {
    fs::remove_all(folder_);
    fs::create_directories(images());
    input_.image_path = images();
    input_.database_path = folder_ / "database.db";
    input_.work_path = folder_ / "work";
    input_.camera = camera;
    input_.frame.origin = flight.origin;
  }

  fs::path images() const { return folder_ / "images"; }
  SparseUpdateInput& input() { return input_; }
  const SparseUpdateResult& result() const { return result_; }
  std::size_t count() const { return count_; }

  // The next photos arrive and are added to the model.
  StageCost Grow(int photos) {
    for (int i = 0; i < photos; ++i, ++count_) {
      fs::create_hard_link(photos_ / flight_.names[count_], images() / flight_.names[count_]);
    }
    before_ = result_.model;
    input_.model = before_.images.empty() ? nullptr : &before_;
    if (input_.model != nullptr) input_.frame = result_.frame;
    input_.state = result_.state;
    const StageTimer timer;
    result_ = UpdateSparseModel(input_, options_, {});
    return timer.Stop();
  }

  // Median move of the photos that the model had before, in pixels at the distance of the scene.
  double MedianMovePx(double focal_px) const {
    std::vector<double> moves;
    for (const auto& [id, image] : before_.images) {
      const auto found = result_.model.images.find(id);
      if (found == result_.model.images.end()) continue;
      const Rigid3d& now = found->second.cam_from_world;
      double sum = 0, count = 0;
      for (const Keypoint2D& keypoint : image.keypoints) {
        const auto point = before_.points.find(keypoint.point3D_id);
        if (point == before_.points.end()) continue;
        const Eigen::Vector3d a = image.cam_from_world * point->second.position;
        const Eigen::Vector3d b = now * point->second.position;
        sum += focal_px * (a.hnormalized() - b.hnormalized()).norm();
        ++count;
      }
      if (count > 0) moves.push_back(sum / count);
    }
    return moves.empty() ? 0 : Median(moves);
  }

 private:
  fs::path folder_, photos_;
  const Flight& flight_;
  SparseUpdateOptions options_;
  SparseUpdateInput input_;
  SparseUpdateResult result_;
  Reconstruction before_;
  std::size_t count_ = 0;
};

void AddCosts(const std::string& who, const StepCosts& costs, BenchReport* report) {
  for (const auto& [step, cost] : costs) {
    report->Add(who + ": " + step, cost.cpu_s, "CPU s");
    report->Add(who + ": " + step + ", wall", cost.wall_s, "s");
  }
}

void AddModel(const std::string& who, const Reconstruction& model, BenchReport* report) {
  report->Add(who + ": photos", static_cast<double>(model.images.size()), "photos");
  report->Add(who + ": points", static_cast<double>(model.points.size()), "points");
  report->Add(who + ": observations", Observations(model), "observations");
  report->Add(who + ": reprojection error", MeanErrorPx(model), "px");
}

// Median distance of the camera centres from the truth, as they are and after a similarity.
struct PoseErrors {
  double as_is_m = 0, aligned_m = 0, scale_percent = 0;
};
PoseErrors PoseErrorsOf(const Reconstruction& model, const Flight& flight) {
  const std::vector<CameraPair> pairs = PairCameras(model, flight.cam_from_world);
  const Sim3d truth_from_model = AlignByCameras(pairs).truth_from_model;
  std::vector<double> as_is, aligned;
  for (const CameraPair& pair : pairs) {
    as_is.push_back((pair.center_in_model - pair.center_in_truth).norm());
    aligned.push_back((truth_from_model * pair.center_in_model - pair.center_in_truth).norm());
  }
  return {Median(as_is), Median(aligned), 100 * std::abs(1 / truth_from_model.scale - 1)};
}

std::vector<std::pair<std::string, std::string>> PairsWith(const fs::path& database_path,
                                                           const std::vector<std::string>& names) {
  const Database database = Database::Open(database_path, Database::Access::kReadOnly);
  const std::map<ImageId, DatabaseImage> images = database.ReadImages();
  const std::set<std::string> wanted(names.begin(), names.end());
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const auto& [pair, count] : database.NumMatches()) {
    const std::string &a = images.at(pair.first).name, &b = images.at(pair.second).name;
    if (wanted.count(a) + wanted.count(b) > 0) pairs.emplace_back(a, b);
  }
  return pairs;
}

// The two first models and the updates, side by side.
class Comparison {
 public:
  Comparison(const BenchOptions& options, const Flight& flight, const fs::path& photos,
             const Camera& camera, const SparseUpdateOptions& update, BenchReport* report)
      : options_(options),
        flight_(flight),
        report_(report),
        colmap_(""),
        focal_px_(camera.params[0]),
        ours_(options.work_path / "ours", flight, photos, camera, update),
        plain_(options.work_path / "plain", camera, update, &colmap_) {}

  void Run() {
    FirstModels();
    for (int i = 1; i <= options_.updates; ++i) Update(i);
    if (options_.updates > 0) {
      report_->Add("updates: our mean CPU time / COLMAP from scratch",
                   update_cpu_s_ / options_.updates / scratch_cpu_s_, "ratio",
                   options_.plain ? std::optional(AtMost(0.1)) : std::nullopt);
      report_->Add("updates: median move of old photos", Median(moves_), "px", AtMost(0.1));
    }
    if (options_.curve_to > 0) Curve();
    AddModel("ours at the end", ours_.result().model, report_);
    const PoseErrors errors = PoseErrorsOf(ours_.result().model, flight_);
    report_->Add("ours at the end: median position error", errors.as_is_m * 1000, "mm");
  }

 private:
  void FirstModels() {
    const StageCost cost = ours_.Grow(options_.photos);
    fs::copy_file(ours_.input().database_path, options_.work_path / "first.db",
                  fs::copy_options::overwrite_existing);
    AddCosts("ours, first model", ours_.result().cost_of_step, report_);
    report_->Add("ours, first model: CPU time", cost.cpu_s, "CPU s");
    report_->Add("ours, first model: pairs", ours_.result().num_pairs, "pairs");
    AddModel("ours, first model", ours_.result().model, report_);
    const PoseErrors errors = PoseErrorsOf(ours_.result().model, flight_);
    report_->Add("ours, first model: median position error",
                 100 * errors.as_is_m / flight_.scene_size_m, "% of scene", AtMost(0.05));
    report_->Add("ours, first model: median position error after alignment",
                 100 * errors.aligned_m / flight_.scene_size_m, "% of scene");
    if (options_.plain) FirstOfPlain(cost);
  }

  void FirstOfPlain(const StageCost& our_cost) {
    const StepCosts costs = plain_.FromScratch(ours_.images(), options_.plain_neighbors);
    scratch_cpu_s_ = Total(costs).cpu_s;
    AddCosts("COLMAP, first model", costs, report_);
    report_->Add("COLMAP, first model: CPU time", scratch_cpu_s_, "CPU s");
    AddModel("COLMAP, first model", plain_.model(), report_);
    const PoseErrors errors = PoseErrorsOf(plain_.model(), flight_);
    report_->Add("COLMAP, first model: median position error after alignment",
                 100 * errors.aligned_m / flight_.scene_size_m, "% of scene");
    const Reconstruction &mine = ours_.result().model, &theirs = plain_.model();
    report_->Add("first model: our CPU time / COLMAP's", our_cost.cpu_s / scratch_cpu_s_, "ratio",
                 AtMost(0.4));
    report_->Add(
        "first model: our photos - COLMAP's",
        static_cast<double>(mine.images.size()) - static_cast<double>(theirs.images.size()),
        "photos", AtLeast(0));
    report_->Add(
        "first model: our points / COLMAP's",
        static_cast<double>(mine.points.size()) / static_cast<double>(theirs.points.size()),
        "ratio", AtLeast(1));
    report_->Add("first model: our reprojection error / COLMAP's",
                 MeanErrorPx(mine) / MeanErrorPx(theirs), "ratio", AtMost(1));
  }

  void Update(int number) {
    const std::string who = "update " + std::to_string(number);
    const std::size_t begin = ours_.count();
    const StageCost cost = ours_.Grow(options_.batch);
    const std::vector<std::string> names(
        flight_.names.begin() + static_cast<std::ptrdiff_t>(begin),
        flight_.names.begin() + static_cast<std::ptrdiff_t>(ours_.count()));
    AddCosts("ours, " + who, ours_.result().cost_of_step, report_);
    report_->Add("ours, " + who + ": CPU time", cost.cpu_s, "CPU s");
    report_->Add("ours, " + who + ": registered",
                 static_cast<double>(ours_.result().newly_registered.size()), "photos");
    update_cpu_s_ += cost.cpu_s;
    moves_.push_back(ours_.MedianMovePx(focal_px_));
    report_->Add("ours, " + who + ": median move of old photos", moves_.back(), "px");
    if (!options_.plain) return;
    report_->Add("ours, " + who + ": CPU time / COLMAP from scratch", cost.cpu_s / scratch_cpu_s_,
                 "ratio", AtMost(0.1));
    const StepCosts costs =
        plain_.Update(ours_.images(), names, PairsWith(ours_.input().database_path, names));
    AddCosts("COLMAP, " + who, costs, report_);
    report_->Add("COLMAP, " + who + ": CPU time", Total(costs).cpu_s, "CPU s");
    AddModel("COLMAP, " + who, plain_.model(), report_);
    AddModel("ours, " + who, ours_.result().model, report_);
  }

  void Curve() {
    std::vector<double> early, late;
    double cpu_s = 0;
    int updates = 0;
    while (static_cast<int>(ours_.count()) + options_.batch <= options_.curve_to) {
      const bool adjusted_before = ours_.result().state.photos_at_last_adjustment > 0;
      const int adjusted = ours_.result().state.photos_at_last_adjustment;
      const StageCost cost = ours_.Grow(options_.batch);
      const bool adjusts_all =
          adjusted_before && ours_.result().state.photos_at_last_adjustment != adjusted;
      report_->Add("curve, " + std::to_string(ours_.count()) + " photos: pairs",
                   ours_.result().num_pairs, "pairs");
      report_->Add("curve, " + std::to_string(ours_.count()) + " photos" +
                       (adjusts_all ? ", adjusting all" : ""),
                   cost.cpu_s, "CPU s");
      AddCosts("curve, " + std::to_string(ours_.count()) + " photos", ours_.result().cost_of_step,
               report_);
      cpu_s += cost.cpu_s;
      ++updates;
      if (adjusts_all) continue;
      if (static_cast<int>(ours_.count()) <= options_.curve_to / 2) early.push_back(cost.cpu_s);
      if (static_cast<int>(ours_.count()) > options_.curve_to * 3 / 4) late.push_back(cost.cpu_s);
    }
    report_->Add("curve: mean, adjustments of all included", cpu_s / updates, "CPU s");
    if (early.empty() || late.empty()) return;
    report_->Add("curve: median of the last quarter / of the first half",
                 Median(late) / Median(early), "ratio", AtMost(1.5));
  }

  const BenchOptions& options_;
  const Flight& flight_;
  BenchReport* report_;
  ColmapProgram colmap_;
  double focal_px_;
  OurProject ours_;
  PlainColmap plain_;
  double scratch_cpu_s_ = 0, update_cpu_s_ = 0;
  std::vector<double> moves_;
};

// First models and updates from positions with noise: what the scale is worth. Features, and the
// matches of the pairs chosen without noise, are those of the comparison.
void RunWithNoise(const BenchOptions& options, const Flight& flight, const fs::path& photos,
                  const Camera& camera, const SparseUpdateOptions& update, BenchReport* report) {
  for (int seed = 1; seed <= options.noise_seeds; ++seed) {
    const std::string who = "GPS noise, seed " + std::to_string(seed);
    OurProject project(options.work_path / "noise", flight, photos, camera, update);
    fs::copy_file(options.work_path / "first.db", project.input().database_path);
    project.input().geo_position_of_photo =
        NoisyPositions(flight, options.noise_m, static_cast<std::uint64_t>(seed));
    project.Grow(options.photos);
    const PoseErrors first = PoseErrorsOf(project.result().model, flight);
    report->Add(who + ", first model: scale error", first.scale_percent, "%", AtMost(1));
    report->Add(who + ", first model: median position error", first.as_is_m, "m");
    for (int i = 0; i < options.updates; ++i) project.Grow(options.batch);
    const PoseErrors last = PoseErrorsOf(project.result().model, flight);
    report->Add(who + ", after the updates: scale error", last.scale_percent, "%", AtMost(1));
    report->Add(who + ", after the updates: median position error", last.as_is_m, "m");
    report->Add(who + ", after the updates: median position error after alignment", last.aligned_m,
                "m");
  }
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  SparseUpdateOptions update;
  OptionSet set;
  Bind(set, &options);
  BindOptions(set, &update);
  set.Parse(arguments);
  if (set.HelpRequested()) {
    std::printf("bench_sfm: sparse_updater beside plain COLMAP\n\n%s", set.HelpText().c_str());
    return 0;
  }
  if (options.work_path.empty()) throw UsageError("--work_path is required");
  const fs::path photos = options.work_path / "photos";
  const int total = std::max(options.photos + options.updates * options.batch, options.curve_to);
  ConsoleSink sink(LogLevel::kInfo);
  const Flight flight =
      FlyAroundChurch(total, options.texel_scale, photos, JobControl(&sink, nullptr));
  const PinholeCamera low = SimulatedCameraOptions().LowCamera();
  const Camera camera = {
      CameraModel::kSimplePinhole, low.width, low.height, {low.fx, low.cx, low.cy}};
  BenchReport report("sfm");
  Comparison(options, flight, photos, camera, update, &report).Run();
  if (options.noise) RunWithNoise(options, flight, photos, camera, update, &report);
  if (options.matchers) {
    RaceMatchers(options.work_path / "ours" / "database.db", update.matching, &report);
  }
  report.Write(options.results_path);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_sfm", argc, argv, colmap_ext::Run);
}
