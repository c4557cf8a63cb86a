#include "feature_stage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>

#include "colmap_ext/scene/photo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

fs::path Beside(const fs::path& path, const char* suffix) { return path.string() + suffix; }

void RemoveDatabase(const fs::path& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    fs::remove(Beside(path, suffix), ignored);
  }
}

// Always the same name, so that the next run removes what a killed one left.
fs::path WorkingPathFor(const fs::path& path) {
  return path.parent_path() / ("." + path.stem().string() + ".update" + path.extension().string());
}

bool HasPendingWrites(const fs::path& database) {
  const fs::path log = Beside(database, "-wal");
  return fs::exists(log) && fs::file_size(log) > 0;
}

// Versions of COLMAP that read each other's databases without losing anything: until 3.13, and from
// 4.0 on. 0 stands for a database made by a script, with 3.8's tables.
constexpr int kFirstVersionWithFrames = 4000000;

void RequireMatchingVersion(const fs::path& path, const Database& database, int program_version,
                            const std::string& program_name) {
  const int version = database.user_version();
  const bool has_frames = version >= kFirstVersionWithFrames;
  const bool program_has_frames = program_version >= kFirstVersionWithFrames;
  if (version <= program_version && has_frames == program_has_frames) return;
  throw Error(path.string() + ": this database was made by another version of COLMAP (stamp " +
              std::to_string(version) + ") than the program in use (" + program_name + ", stamp " +
              std::to_string(program_version) +
              "); name that version's program by --colmap_path, or start a new database");
}

void CheckGivenCamera(const Camera& camera, const CatalogPhoto& photo) {
  if (camera.width == photo.metadata.width && camera.height == photo.metadata.height) return;
  throw Error(photo.name + ": it is " + std::to_string(photo.metadata.width) + " x " +
              std::to_string(photo.metadata.height) + " pixels, but the given camera is of " +
              std::to_string(camera.width) + " x " + std::to_string(camera.height));
}

// A given camera without size is that of the photos.
Camera SizedLike(Camera camera, const CatalogPhoto& photo) {
  if (camera.width == 0 && camera.height == 0) {
    camera.width = photo.metadata.width;
    camera.height = photo.metadata.height;
  }
  return camera;
}

bool SameCamera(const Camera& a, const Camera& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height && a.params == b.params;
}

// Finds or adds the camera of each new photo.
class CameraChooser {
 public:
  CameraChooser(const PhotoCatalog& catalog, const std::optional<Camera>& given,
                const std::map<ImageId, DatabaseImage>& images,
                std::map<CameraId, DatabaseCamera> cameras, Database::Transaction* transaction)
      : given_(given), cameras_(std::move(cameras)), transaction_(transaction) {
    std::map<std::string, CameraId> camera_of_name;
    for (const auto& [id, image] : images) camera_of_name[image.name] = image.camera_id;
    for (const CatalogPhoto& photo : catalog.photos) {
      const auto found = camera_of_name.find(photo.name);
      if (found != camera_of_name.end()) Remember(photo, found->second);
    }
    if (given_ && !catalog.photos.empty()) given_ = SizedLike(*given_, catalog.photos.front());
  }

  CameraId For(const CatalogPhoto& photo) { return given_ ? Given(photo) : Guessed(photo); }

 private:
  void Remember(const CatalogPhoto& photo, CameraId id) {
    const auto camera = cameras_.find(id);
    if (camera == cameras_.end()) return;
    const bool same_size = camera->second.camera.width == photo.metadata.width &&
                           camera->second.camera.height == photo.metadata.height;
    if (same_size) camera_of_key_.emplace(CameraKey(photo.metadata), id);
  }

  CameraId Given(const CatalogPhoto& photo) {
    CheckGivenCamera(*given_, photo);
    for (const auto& [id, camera] : cameras_) {
      if (SameCamera(camera.camera, *given_)) return id;
    }
    return Add({*given_, true});
  }

  CameraId Guessed(const CatalogPhoto& photo) {
    const auto known = camera_of_key_.find(CameraKey(photo.metadata));
    if (known != camera_of_key_.end()) return known->second;
    const CameraId id = Add({GuessCamera(photo.metadata), photo.metadata.focal_px.has_value()});
    camera_of_key_[CameraKey(photo.metadata)] = id;
    return id;
  }

  CameraId Add(const DatabaseCamera& camera) {
    const CameraId id = cameras_.empty() ? 1 : cameras_.rbegin()->first + 1;
    transaction_->InsertCamera(id, camera);
    cameras_[id] = camera;
    return id;
  }

  std::optional<Camera> given_;
  std::map<CameraId, DatabaseCamera> cameras_;
  std::map<std::string, CameraId> camera_of_key_;
  Database::Transaction* transaction_;
};

std::optional<PositionPrior> PriorOf(const CatalogPhoto& photo) {
  if (!photo.geo) return std::nullopt;
  return PositionPrior{{photo.geo->lat_deg, photo.geo->lon_deg, photo.geo->height_m},
                       PriorFrame::kWgs84};
}

// COLMAP reads a photo with its lower half missing without complaint; we do not.
void RequireReadablePhotos(const std::vector<std::string>& names, const fs::path& image_path,
                           const JobControl& job) {
  std::vector<std::string> complaints(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t i) {
    if (job.IsCancelled()) return;
    try {
      ReadPhoto((image_path / names[i]).string());
    } catch (const Error& error) {
      complaints[i] = error.what();
    }
  });
  job.ThrowIfCancelled();
  for (const std::string& complaint : complaints) {
    if (!complaint.empty()) throw Error(complaint);
  }
}

std::vector<std::string> PhotosWithoutFeatures(const PhotoCatalog& catalog,
                                               const fs::path& database_path) {
  const Database database = Database::Open(database_path, Database::Access::kReadOnly);
  const std::map<ImageId, std::size_t> counts = database.NumKeypoints();
  std::set<std::string> done;
  for (const auto& [id, image] : database.ReadImages()) {
    if (counts.count(id) > 0) done.insert(image.name);
  }
  std::vector<std::string> names;
  for (const CatalogPhoto& photo : catalog.photos) {
    if (done.count(photo.name) == 0) names.push_back(photo.name);
  }
  return names;
}

}  // namespace

WorkingDatabase::WorkingDatabase(const fs::path& database_path, const fs::path& base_path,
                                 const fs::path& work_path, ColmapProgram* colmap,
                                 const JobControl& job)
    : target_(database_path), path_(WorkingPathFor(database_path)), empty_(work_path / "empty.db") {
  RequireWritableFolder(fs::absolute(database_path).parent_path(), "folder of the database");
  RemoveDatabase(path_);
  RemoveDatabase(empty_);
  colmap->Run("database_creator", {{"database_path", empty_.string()}}, work_path / "database.log",
              job);
  fs::path source = empty_;
  if (fs::exists(target_)) {
    // Opening and closing brings what a killed program left in the -wal file into the database.
    if (HasPendingWrites(target_)) Database::Open(target_, Database::Access::kReadWrite);
    source = target_;
  } else if (!base_path.empty()) {
    RequireFile(base_path, "database");
    source = base_path;
  }
  const int program_version = Database::Open(empty_, Database::Access::kReadOnly).user_version();
  RequireMatchingVersion(source, Database::Open(source, Database::Access::kReadOnly),
                         program_version, colmap->dialect().version());
  Database::Copy(source, path_);
}

WorkingDatabase::~WorkingDatabase() {
  RemoveDatabase(path_);
  RemoveDatabase(empty_);
}

void WorkingDatabase::Commit() {
  if (HasPendingWrites(target_)) {
    throw Error(target_.string() +
                ": another program is writing to this database; close it and run "
                "the same command again");
  }
  if (HasPendingWrites(path_)) Database::Open(path_, Database::Access::kReadWrite);
  CommitTemporaryFile(path_, target_);
}

std::vector<std::string> AddPhotos(const PhotoCatalog& catalog,
                                   const std::optional<Camera>& given_camera, Database* database) {
  const std::map<ImageId, DatabaseImage> images = database->ReadImages();
  std::set<std::string> known;
  for (const auto& [id, image] : images) known.insert(image.name);
  ImageId next_id = images.empty() ? 1 : images.rbegin()->first + 1;
  std::vector<std::string> added;
  Database::Transaction transaction(*database);
  CameraChooser cameras(catalog, given_camera, images, database->ReadCameras(), &transaction);
  for (const CatalogPhoto& photo : catalog.photos) {
    if (known.count(photo.name) > 0) continue;
    transaction.InsertImage(next_id++, {photo.name, cameras.For(photo), PriorOf(photo)});
    added.push_back(photo.name);
  }
  transaction.Commit();
  return added;
}

void ExtractFeatures(const PhotoCatalog& catalog, const fs::path& image_path,
                     const fs::path& database_path, const fs::path& log_path,
                     const SparseUpdateOptions& options, ColmapProgram* colmap,
                     const JobControl& job) {
  const std::vector<std::string> names = PhotosWithoutFeatures(catalog, database_path);
  if (names.empty()) return;
  job.Info("features of " + std::to_string(names.size()) + " photos");
  RequireReadablePhotos(names, image_path, job);
  std::string list;
  for (const std::string& name : names) list += name + "\n";
  const fs::path list_path = log_path.parent_path() / "new_photos.txt";
  WriteFileAtomically(list_path, list);
  colmap->Run("feature_extractor",
              {{"database_path", database_path.string()},
               {"image_path", image_path.string()},
               {"image_list_path", list_path.string()},
               {"SiftExtraction.use_gpu", "0"},
               {"SiftExtraction.first_octave", std::to_string(options.first_octave)},
               {"SiftExtraction.max_num_features", std::to_string(options.max_num_features)},
               {"SiftExtraction.max_image_size", std::to_string(options.max_image_size)}},
              log_path, job);
  fs::remove(list_path);
  const std::vector<std::string> left = PhotosWithoutFeatures(catalog, database_path);
  if (!left.empty()) {
    throw Error(
        (image_path / left.front()).string() +
        ": `colmap feature_extractor` could not read this photo; its output: " + log_path.string());
  }
}

}  // namespace colmap_ext
