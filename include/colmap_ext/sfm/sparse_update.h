// Photos to a sparse model, and more photos into the model that is there: drives the `colmap`
// program (paper, Sec. "Sparse Reconstruction").
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/sfm/bundle_adjustment.h"
#include "colmap_ext/sfm/georegistration.h"
#include "colmap_ext/sfm/matching.h"
#include "colmap_ext/sfm/pairing.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {

struct SparseUpdateOptions {
  // SIFT's first octave: 0 starts at the photo's own size, three times faster than COLMAP's -1
  // (doubled size), with a third of the features; [-1, 4].
  int first_octave = 0;
  int max_num_features = 4096;  // a photo, the largest ones are kept; >= 100
  int max_image_size = 3200;    // longer side, px; larger photos are scaled down for SIFT; >= 100
  // When the photos registered since the last adjustment of all poses exceed this part of those
  // that were adjusted, all poses are adjusted again, else only the new ones: an update costs what
  // its photos cost, and the adjustments of all, spread over the photos between them, the same at
  // every size; [0, 10].
  double adjust_after_growth = 0.15;
  // Whether focal length and distortion are estimated when the first model is made: 0 no, 1 yes, -1
  // yes unless the camera was given, or all photos look one way (the focal length of flat ground
  // seen from above cannot be told from the height) and EXIF knows it.
  int refine_intrinsics = -1;
  PairingOptions pairing;
  MatchingOptions matching;
  GeoregistrationOptions georegistration;
  BundleOptions bundle;

  std::string Check() const;
};
// Sections "SparseUpdate", "Pairing", "Matching", "Georegistration", "BundleAdjustment".
void BindOptions(OptionSet& set, SparseUpdateOptions* options);

// What has to be remembered between updates, beside the database and the model.
struct SparseState {
  int photos_at_last_adjustment = 0;      // 0: never adjusted by us
  std::vector<std::string> unregistered;  // tried, but did not register; sorted
};
// JSON. A missing file gives the default. Throws Error for a damaged one.
SparseState ReadSparseState(const std::filesystem::path& path);
void WriteSparseState(const SparseState& state, const std::filesystem::path& path);

struct SparseUpdateInput {
  std::filesystem::path colmap_path;    // empty: `colmap` on the PATH
  std::filesystem::path image_path;     // folder of photos
  std::filesystem::path database_path;  // created when there is none
  // Somebody's database to start from when there is none at database_path; copied, never changed.
  std::filesystem::path base_database_path;
  std::filesystem::path work_path;  // logs (kept) and temporary models (removed)
  // The model to continue, null for none; `frame` and `state` belong to it.
  const Reconstruction* model = nullptr;
  // An origin without a metric model is the one that georegistration shall use.
  WorldFrame frame;
  SparseState state;
  // Intrinsics of all new photos when they are known, and then locked. Width and height 0: those of
  // the photos.
  std::optional<Camera> camera;
  // Positions by photo name. Local ones (metres, z up) win over geographic ones, and those over the
  // photos' EXIF.
  std::map<std::string, GeoPosition> geo_position_of_photo;
  std::map<std::string, Eigen::Vector3d> local_position_of_photo;
};

struct SparseUpdateResult {
  Reconstruction model;
  WorldFrame frame;
  SparseState state;
  bool changed = false;                 // false: there was nothing to do, `model` is the given one
  std::vector<std::string> registered;  // names, sorted
  std::vector<std::string> newly_registered;  // ... those that the given model did not have
  std::vector<std::string> unregistered;      // photos of the folder that the model does not have
  // Groups of them that make a model of their own, which nothing joins to this one yet (names,
  // sorted; largest first). Photos that see both let a later call register them.
  std::vector<std::vector<std::string>> other_models;
  // Only when this call georegistered the model, or tried to.
  std::optional<GeoregistrationResult> georegistration;
  // How the measured positions agree with `model` at the end, or why it is not in metres; `scale`
  // is that of this call's georegistration, 1 when the model was in metres before. Absent where no
  // registered photo has a position.
  std::optional<GeoregistrationResult> positions;
  double mean_error_px = 0;  // reprojection, over all observations
  int num_pairs = 0;         // matched in this call
  // The last adjustment of all poses in this call, if there was one.
  std::optional<BundleResult> adjustment_of_all;
  // features, matching, verification, mapping, georegistration, adjustment, saving
  std::map<std::string, StageCost> cost_of_step;
};

// Extracts, matches and registers the photos of `image_path` that the database and the model do not
// have yet. COLMAP's mapper works on the part of the model that they match; time and memory follow
// the number of new photos (see adjust_after_growth). Old poses never jump: between adjustments of
// all they keep every bit, and a given model keeps its gauge. The database is changed in one
// transaction when all is done, the given model is not touched; the same input gives the same
// result on every run. Photos that do not register are named and tried again by the next call that
// brings photos they match. The result is in metres (frame.is_metric_enu) when at least 3
// registered photos have positions that determine it; otherwise `job` is warned why not. Throws
// Error when there is no `colmap` or no photo, a photo cannot be read, fewer than 3 photos
// register, another update of this database is running, or a step of COLMAP fails; UsageError for
// invalid options.
SparseUpdateResult UpdateSparseModel(const SparseUpdateInput& input,
                                     const SparseUpdateOptions& options, const JobControl& job);

// Writes georegistration.json (docs/file_formats.md) into the model's folder, when there are
// positions.
void WriteGeoregistration(const SparseUpdateResult& result, const std::filesystem::path& folder);

}  // namespace colmap_ext
