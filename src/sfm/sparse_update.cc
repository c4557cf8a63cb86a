#include "colmap_ext/sfm/sparse_update.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "feature_stage.h"
#include "mapping_stage.h"
#include "match_stage.h"
#include "photo_catalog.h"
#include "view_places.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMinRegistered = 3;

std::string Rounded(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

// "a, b, c and 7 more"
std::string NameList(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

std::set<std::string> NamesOf(const Reconstruction& model) {
  std::set<std::string> names;
  for (const auto& [id, image] : model.images) names.insert(image.name);
  return names;
}

// Photos of the folder that the model does not have.
std::vector<std::string> MissingPhotos(const PhotoCatalog& catalog, const Reconstruction& model) {
  const std::set<std::string> registered = NamesOf(model);
  std::vector<std::string> missing;
  for (const CatalogPhoto& photo : catalog.photos) {
    if (registered.count(photo.name) == 0) missing.push_back(photo.name);
  }
  return missing;
}

// ... and that were never tried.
std::vector<std::string> UntriedPhotos(const std::vector<std::string>& missing,
                                       const SparseState& state) {
  std::vector<std::string> untried;
  for (const std::string& name : missing) {
    const auto& tried = state.unregistered;
    if (std::find(tried.begin(), tried.end(), name) == tried.end()) untried.push_back(name);
  }
  return untried;
}

double MeanErrorPx(const Reconstruction& model) {
  double sum = 0;
  std::size_t observations = 0;
  for (const auto& [id, point] : model.points) {
    if (point.error_px < 0) continue;
    sum += point.error_px * static_cast<double>(point.track.size());
    observations += point.track.size();
  }
  return observations == 0 ? 0 : sum / static_cast<double>(observations);
}

// The model speaks of photos by id: they must be the database's.
void RequireSamePhotos(const Reconstruction& model, const Database& database) {
  const std::map<ImageId, DatabaseImage> images = database.ReadImages();
  for (const auto& [id, image] : model.images) {
    const auto found = images.find(id);
    if (found != images.end() && found->second.name == image.name) continue;
    throw Error(database.path().string() + ": photo " + image.name + " (id " + std::to_string(id) +
                ") of the given model is not in this database under that id; give the database "
                "that the model was made from");
  }
}

// One call of UpdateSparseModel: the steps share these.
class Updater {
 public:
  Updater(const SparseUpdateInput& input, const SparseUpdateOptions& options, const JobControl& job)
      : input_(input),
        options_(options),
        job_(job),
        colmap_(input.colmap_path),
        catalog_(ReadCatalog(input, job)) {}

  SparseUpdateResult Run() {
    if (input_.model != nullptr && NothingNew()) return Unchanged();
    if (input_.model != nullptr && input_.base_database_path.empty()) {
      RequireFile(input_.database_path, "database of the given model");
    }
    RequireWritableFolder(input_.work_path, "work folder");
    WorkingDatabase database(input_.database_path, input_.base_database_path, input_.work_path,
                             &colmap_, job_);
    result_.frame = input_.frame;
    result_.state = input_.state;
    ExtractStep(database);
    MatchStep(database);
    MapStep(database);
    RequireEnoughPhotos();
    GeoregisterStep();
    FillReport();
    database.Commit();
    return std::move(result_);
  }

 private:
  bool NothingNew() const {
    return UntriedPhotos(MissingPhotos(catalog_, *input_.model), input_.state).empty();
  }

  SparseUpdateResult Unchanged() {
    result_.model = *input_.model;
    result_.frame = input_.frame;
    result_.state = input_.state;
    FillReport();
    result_.changed = false;
    return std::move(result_);
  }

  void ExtractStep(const WorkingDatabase& working) {
    const StageTimer timer;
    {
      Database database = Database::Open(working.path(), Database::Access::kReadWrite);
      if (input_.model != nullptr) RequireSamePhotos(*input_.model, database);
      AddPhotos(catalog_, input_.camera, &database);
    }
    ExtractFeatures(catalog_, input_.image_path, working.path(), Log("features"), options_,
                    &colmap_, job_);
    result_.cost_of_step["features"] = timer.Stop();
  }

  void MatchStep(const WorkingDatabase& working) {
    const StageTimer match_timer;
    std::vector<PairMatches> matches;
    {
      const Database database = Database::Open(working.path(), Database::Access::kReadOnly);
      const std::vector<ImagePair> pairs =
          ChooseImagePairs(database, catalog_, input_, options_.pairing);
      result_.num_pairs = static_cast<int>(pairs.size());
      job_.Info("matching " + std::to_string(pairs.size()) + " pairs of photos");
      matches = MatchImagePairs(database, pairs, options_.matching, job_);
    }
    result_.cost_of_step["matching"] = match_timer.Stop();
    const StageTimer verify_timer;
    VerifyAndStore(matches, working.path(), working.empty_database(), input_.work_path, &colmap_,
                   job_);
    result_.cost_of_step["verification"] = verify_timer.Stop();
  }

  void MapStep(const WorkingDatabase& working) {
    const StageTimer timer;
    const MappingPaths paths = {working.path(), input_.image_path, input_.work_path, Log("mapper")};
    if (input_.model == nullptr) {
      job_.Info("mapping " + std::to_string(catalog_.photos.size()) + " photos");
      MapFirst(paths);
    } else {
      Continue(paths);
    }
    result_.cost_of_step["mapping"] = timer.Stop();
  }

  void MapFirst(const MappingPaths& paths) {
    const bool refine = RefineIntrinsics(options_, input_, catalog_);
    result_.model = MapFromScratch(paths, refine, &colmap_, job_);
    const bool doubtful = refine && options_.refine_intrinsics < 0 && AllFocalsKnown(catalog_);
    if (doubtful && AllLookOneWay(OpticalAxes(result_.model))) {
      job_.Info("all photos look one way: mapping again with the focal length of EXIF");
      result_.model = MapFromScratch(paths, false, &colmap_, job_);
    }
    result_.state.photos_at_last_adjustment = static_cast<int>(result_.model.images.size());
  }

  void Continue(const MappingPaths& paths) {
    const int old_count = static_cast<int>(input_.model->images.size());
    const std::vector<std::string> untried =
        UntriedPhotos(MissingPhotos(catalog_, *input_.model), input_.state);
    const int adjusted = input_.state.photos_at_last_adjustment > 0
                             ? input_.state.photos_at_last_adjustment
                             : old_count;
    const double growth =
        static_cast<double>(old_count + static_cast<int>(untried.size()) - adjusted) / adjusted;
    const bool adjust_all = growth > options_.adjust_after_growth;
    job_.Info("mapping " + std::to_string(untried.size()) + " more photos" +
              (adjust_all ? ", adjusting all poses" : ""));
    result_.model = ContinueModel(paths, *input_.model, adjust_all, &colmap_, job_);
    result_.state.photos_at_last_adjustment =
        adjust_all ? static_cast<int>(result_.model.images.size()) : adjusted;
  }

  void RequireEnoughPhotos() const {
    if (result_.model.images.size() >= kMinRegistered) return;
    throw Error(input_.image_path.string() +
                ": the photos do not overlap enough to make a model (" +
                std::to_string(result_.model.images.size()) + " of " +
                std::to_string(catalog_.photos.size()) +
                " registered; left out: " + NameList(MissingPhotos(catalog_, result_.model)) +
                "); neighbouring photos should share two thirds of what they show");
  }

  void GeoregisterStep() {
    if (result_.frame.is_metric_enu) return;
    const StageTimer timer;
    if (catalog_.num_positions == 0) {
      job_.Warn(
          "no photo has a position (EXIF GPS, geo file or pose file): the model has no scale "
          "and no north, and no flight can be planned from it");
      return;
    }
    const GeoregistrationResult fit =
        Georegister(MeasuredCamerasOf(result_.model, catalog_), options_.georegistration);
    if (fit.world_from_model) {
      TransformReconstruction(*fit.world_from_model, &result_.model);
      result_.frame = {true, catalog_.origin};
      job_.Info("model in metres: " + std::to_string(fit.num_used) + " positions agree within " +
                Rounded(fit.rms_m, 2) + " m RMS");
    } else {
      job_.Warn("the model stays without scale and north: " + fit.refusal);
    }
    for (const PhotoResidual& outlier : fit.outliers) {
      job_.Warn("the position of " + outlier.name + " disagrees with the model by " +
                Rounded(outlier.residual_m, 1) + " m and is not used");
    }
    result_.georegistration = fit;
    result_.cost_of_step["georegistration"] = timer.Stop();
  }

  void FillReport() {
    const std::set<std::string> before =
        input_.model != nullptr ? NamesOf(*input_.model) : std::set<std::string>();
    for (const std::string& name : NamesOf(result_.model)) {
      result_.registered.push_back(name);
      if (before.count(name) == 0) result_.newly_registered.push_back(name);
    }
    result_.unregistered = MissingPhotos(catalog_, result_.model);
    result_.state.unregistered = result_.unregistered;
    result_.mean_error_px = MeanErrorPx(result_.model);
    result_.changed = true;
    if (!result_.unregistered.empty()) {
      job_.Warn(std::to_string(result_.unregistered.size()) +
                " photos did not register (tried again when more photos come): " +
                NameList(result_.unregistered));
    }
  }

  std::filesystem::path Log(const std::string& step) const {
    return input_.work_path / (step + ".log");
  }

  const SparseUpdateInput& input_;
  const SparseUpdateOptions& options_;
  const JobControl& job_;
  ColmapProgram colmap_;
  PhotoCatalog catalog_;
  SparseUpdateResult result_;
};

}  // namespace

SparseUpdateResult UpdateSparseModel(const SparseUpdateInput& input,
                                     const SparseUpdateOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  return Updater(input, options, job).Run();
}

}  // namespace colmap_ext
