#include "colmap_ext/sfm/sparse_update.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/sfm/feature_extraction.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/statistics.h"
#include "colmap_ext/util/text.h"
#include "feature_stage.h"
#include "mapping_stage.h"
#include "match_stage.h"
#include "pair_stage.h"
#include "photo_catalog.h"
#include "point_colors.h"
#include "sub_model.h"
#include "update_database.h"
#include "view_places.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMinRegistered = 3;

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

std::map<std::string, ImageId> IdsOf(const std::map<ImageId, DatabaseImage>& images) {
  std::map<std::string, ImageId> ids;
  for (const auto& [id, image] : images) ids[image.name] = id;
  return ids;
}

// How good measured positions are, one sigma of an axis, from how far photos of the model are from
// theirs. That is too much by what the model itself is wrong, so they never pull too hard.
double PositionSigma(const std::map<ImageId, PhotoPrior>& priors, const Reconstruction& model) {
  constexpr double kMinSigmaM = 0.02;           // of RTK receivers
  constexpr double kMedianOfThreeAxes = 1.538;  // median length of a vector of unit normals
  std::vector<double> residuals;
  for (const auto& [id, prior] : priors) {
    const Eigen::Vector3d center = CameraCenter(model.images.at(id).cam_from_world);
    residuals.push_back((center - *prior.position_in_world).norm());
  }
  if (residuals.empty()) return kMinSigmaM;
  return std::max(MiddleValue(std::move(residuals)) / kMedianOfThreeAxes, kMinSigmaM);
}

// Receivers are right about which of their positions are better, less so about how good they are:
// of the accuracies that they tell only the ratios are kept. `sigma_m`: of the middle one.
void ScaleSigmas(double sigma_m, std::map<ImageId, PhotoPrior>* priors) {
  if (priors->empty()) return;
  std::vector<double> told;
  for (const auto& [id, prior] : *priors) told.push_back(prior.sigma_horizontal_m);
  const double factor = sigma_m / MiddleValue(std::move(told));
  for (auto& [id, prior] : *priors) {
    prior.sigma_horizontal_m *= factor;
    prior.sigma_vertical_m *= factor;
  }
}

// The model speaks of photos by id: they must be the database's.
void RequireSamePhotos(const Reconstruction& model, const DatabaseView& database) {
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
    UpdateDatabase databases(input_.database_path, input_.base_database_path, input_.work_path,
                             &colmap_, job_);
    result_.frame = input_.frame;
    result_.state = input_.state;
    ExtractStep(databases);
    MatchStep(databases);
    MapStep(databases);
    RequireEnoughPhotos();
    GeoregisterStep();
    AdjustStep();
    FillReport();
    ColorPoints(input_.image_path, result_.newly_registered, &result_.model);
    SaveStep(&databases);
    return std::move(result_);
  }

  void Extract() {
    RequireWritableFolder(input_.work_path, "work folder");
    UpdateDatabase databases(input_.database_path, input_.base_database_path, input_.work_path,
                             &colmap_, job_);
    ExtractStep(databases);
    databases.Commit();
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

  void ExtractStep(const UpdateDatabase& databases) {
    const StageTimer timer;
    if (input_.model != nullptr) RequireSamePhotos(*input_.model, DatabaseView(databases));
    AddPhotos(catalog_, input_.camera, databases);
    ExtractFeatures(catalog_, input_.image_path, databases, Log("features"), options_, &colmap_,
                    job_);
    result_.cost_of_step["features"] = timer.Stop();
  }

  void MatchStep(const UpdateDatabase& databases) {
    const StageTimer match_timer;
    std::vector<PairMatches> matches;
    {
      const DatabaseView view(databases);
      const std::vector<ImagePair> pairs =
          ChooseImagePairs(view, catalog_, input_, options_.pairing);
      result_.num_pairs = static_cast<int>(pairs.size());
      job_.Info("matching " + std::to_string(pairs.size()) + " pairs of photos");
      matches = MatchImagePairs(view, pairs, options_.matching, job_);
    }
    result_.cost_of_step["matching"] = match_timer.Stop();
    const StageTimer verify_timer;
    VerifyAndStore(matches, databases, input_.work_path, options_.matching, &colmap_, job_);
    result_.cost_of_step["verification"] = verify_timer.Stop();
  }

  void MapStep(const UpdateDatabase& databases) {
    const StageTimer timer;
    const MappingPaths paths = {databases.draft(), input_.image_path, input_.work_path,
                                Log("mapper")};
    const DatabaseView view(databases);
    ids_ = IdsOf(view.ReadImages());
    pairs_ = view.TwoViewSummaries();
    if (input_.model == nullptr) {
      MapFirst(databases, paths);
    } else {
      Continue(databases, paths);
    }
    result_.other_models = MapOtherModels(databases);
    result_.cost_of_step["mapping"] = timer.Stop();
  }

  void MapFirst(const UpdateDatabase& databases, const MappingPaths& paths) {
    job_.Info("mapping " + std::to_string(catalog_.photos.size()) + " photos");
    std::set<ImageId> all;
    for (const auto& [name, id] : ids_) all.insert(id);
    FillForMapper(all, databases, databases.draft());
    refine_intrinsics_ = RefineIntrinsics(options_, input_, catalog_);
    result_.model = MapFromScratch(paths, refine_intrinsics_, &colmap_, job_);
    const bool doubtful =
        refine_intrinsics_ && options_.refine_intrinsics < 0 && AllFocalsKnown(catalog_);
    if (doubtful && AllLookOneWay(OpticalAxes(result_.model))) {
      job_.Info("all photos look one way: mapping again with the focal length of EXIF");
      refine_intrinsics_ = false;
      result_.model = MapFromScratch(paths, false, &colmap_, job_);
    }
  }

  // The mapper continues the part of the model that the new photos match.
  void Continue(const UpdateDatabase& databases, const MappingPaths& paths) {
    result_.model = *input_.model;
    std::set<ImageId> untried;
    for (const std::string& name :
         UntriedPhotos(MissingPhotos(catalog_, *input_.model), input_.state)) {
      untried.insert(ids_.at(name));
    }
    const UpdateScope scope = ChooseScope(*input_.model, pairs_, untried);
    job_.Info("mapping " + std::to_string(scope.missing.size()) + " more photos beside " +
              std::to_string(scope.registered.size()) + " of the model");
    if (scope.registered.empty()) return;  // nothing that they match
    std::set<ImageId> all = scope.registered;
    all.insert(scope.missing.begin(), scope.missing.end());
    FillForMapper(all, databases, databases.draft());
    const Reconstruction before = SubModel(*input_.model, scope.registered);
    const Reconstruction after = ContinueModel(paths, before, &colmap_, job_);
    merged_ = MergeSubModel(before, after, &result_.model);
  }

  // What photos that stay out make by themselves.
  std::vector<std::vector<std::string>> MapOtherModels(const UpdateDatabase& databases) {
    std::set<ImageId> missing;
    for (const std::string& name : MissingPhotos(catalog_, result_.model)) {
      missing.insert(ids_.at(name));
    }
    std::set<ImageId> joined;
    for (const auto& [pair, summary] : pairs_) {
      if (summary.num_inliers < kMinInliers) continue;
      if (missing.count(pair.first) == 0 || missing.count(pair.second) == 0) continue;
      joined.insert({pair.first, pair.second});
    }
    if (joined.size() < kMinRegistered || result_.model.images.empty()) return {};
    const std::filesystem::path path = input_.work_path / "others.db";
    std::filesystem::remove(path);
    Database::Copy(databases.empty_database(), path);
    FillForMapper(joined, databases, path);
    std::vector<std::vector<std::string>> groups;
    for (const Reconstruction& model : MapAll(
             {path, input_.image_path, input_.work_path, Log("mapper_others")}, &colmap_, job_)) {
      const std::set<std::string> names = NamesOf(model);
      if (names.size() >= kMinRegistered) groups.emplace_back(names.begin(), names.end());
    }
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path.string() + suffix);
    std::stable_sort(groups.begin(), groups.end(),
                     [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return groups;
  }

  // All poses after the first mapping and after enough growth, else those of the new photos with
  // the points that changed.
  void AdjustStep() {
    const StageTimer timer;
    const int count = static_cast<int>(result_.model.images.size());
    int& adjusted = result_.state.photos_at_last_adjustment;
    if (input_.model != nullptr && adjusted == 0) {
      adjusted = static_cast<int>(input_.model->images.size());  // by whoever made it
    }
    const double growth = adjusted == 0 ? std::numeric_limits<double>::infinity()
                                        : static_cast<double>(count - adjusted) / adjusted;
    BundleSelection selection;
    BundleOptions bundle = options_.bundle;
    const bool adjust_all = growth > options_.adjust_after_growth;
    if (adjust_all) {
      job_.Info("adjusting all " + std::to_string(count) + " poses");
      bundle.refine_focal_length |= refine_intrinsics_;
      bundle.refine_extra_params |= refine_intrinsics_;
      adjusted = count;
    } else {
      selection.free_images = merged_.new_images;
      selection.free_points = merged_.changed_points;
      if (selection.free_points->empty()) return;
    }
    selection.prior_of_image = Priors();
    const BundleResult fit = AdjustBundle(selection, bundle, job_, &result_.model);
    if (adjust_all) result_.adjustment_of_all = fit;
    result_.cost_of_step["adjustment"] = timer.Stop();
  }

  // Measured positions of the photos of the model, once it is in their world.
  std::map<ImageId, PhotoPrior> Priors() const {
    std::map<ImageId, PhotoPrior> priors;
    const bool same_frame = result_.frame.origin.has_value() == catalog_.origin.has_value();
    if (!result_.frame.is_metric_enu || !same_frame) return priors;
    for (const CatalogPhoto& photo : catalog_.photos) {
      const ImageId id = ids_.at(photo.name);
      if (!photo.position_in_world || result_.model.images.count(id) == 0) continue;
      priors[id] = {photo.position_in_world, photo.sigma_horizontal_m.value_or(1),
                    photo.sigma_vertical_m.value_or(1), photo.up_in_cam};
    }
    ScaleSigmas(PositionSigma(priors, result_.model), &priors);
    return priors;
  }

  void SaveStep(UpdateDatabase* databases) {
    const StageTimer timer;
    databases->Commit();
    // COLMAP's frames of these photos are the database's, whatever the draft called them.
    result_.model.frame_table =
        Database::Open(input_.database_path, Database::Access::kReadOnly).ReadFrameTable();
    result_.cost_of_step["saving"] = timer.Stop();
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
                FormatNumber("%.2f", fit.rms_m) + " m RMS");
    } else {
      job_.Warn("the model stays without scale and north: " + fit.refusal);
    }
    for (const PhotoResidual& outlier : fit.outliers) {
      job_.Warn("the position of " + outlier.name + " disagrees with the model by " +
                FormatNumber("%.1f", outlier.residual_m) + " m and is not used");
    }
    result_.georegistration = fit;
    result_.cost_of_step["georegistration"] = timer.Stop();
  }

  void ComparePositionsStep() {
    const bool same_frame = result_.frame.origin.has_value() == catalog_.origin.has_value();
    const std::vector<MeasuredCamera> cameras = MeasuredCamerasOf(result_.model, catalog_);
    if (cameras.empty()) return;
    if (!result_.frame.is_metric_enu || !same_frame) {
      result_.positions = result_.georegistration;
      return;
    }
    result_.positions = ComparePositions(cameras, options_.georegistration);
    if (!result_.georegistration) return;
    result_.positions->world_from_model = result_.georegistration->world_from_model;
    result_.positions->tilt_uncertainty_deg = result_.georegistration->tilt_uncertainty_deg;
    result_.positions->gravity_from_cameras = result_.georegistration->gravity_from_cameras;
  }

  void FillReport() {
    ComparePositionsStep();
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
    for (const std::vector<std::string>& names : result_.other_models) {
      job_.Warn(std::to_string(names.size()) +
                " of them make a model of their own, which no photo joins to this one yet: " +
                NameList(names));
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
  std::map<std::string, ImageId> ids_;         // in the database, by name
  std::map<ImagePair, TwoViewSummary> pairs_;  // ... verified
  MergedPart merged_;
  bool refine_intrinsics_ = false;
};

}  // namespace

SparseUpdateResult UpdateSparseModel(const SparseUpdateInput& input,
                                     const SparseUpdateOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  return Updater(input, options, job).Run();
}

void ExtractNewFeatures(const SparseUpdateInput& input, const SparseUpdateOptions& options,
                        const JobControl& job) {
  ThrowIfInvalid(options.Check());
  Updater(input, options, job).Extract();
}

}  // namespace colmap_ext
