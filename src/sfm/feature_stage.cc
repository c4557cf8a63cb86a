#include "feature_stage.h"

#include <map>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/scene/photo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

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
  ParallelFor(names.size(), [&](std::size_t i) {
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

// Ids by name, in name order.
std::map<std::string, ImageId> PhotosWithoutFeatures(const PhotoCatalog& catalog,
                                                     const DatabaseView& database) {
  const std::map<ImageId, std::size_t> counts = database.NumKeypoints();
  std::map<std::string, ImageId> ids;
  for (const auto& [id, image] : database.ReadImages()) {
    if (counts.count(id) == 0) ids[image.name] = id;
  }
  std::map<std::string, ImageId> wanted;
  for (const CatalogPhoto& photo : catalog.photos) {
    const auto found = ids.find(photo.name);
    if (found != ids.end()) wanted.insert(*found);
  }
  return wanted;
}

// `colmap feature_extractor` keeps the ids of photos that it finds.
void AddRowsToDraft(const std::map<std::string, ImageId>& photos, const UpdateDatabase& databases) {
  const DatabaseView view(databases);
  Database draft = Database::Open(databases.draft(), Database::Access::kReadWrite);
  const std::map<CameraId, DatabaseCamera> cameras = draft.ReadCameras();
  const std::map<ImageId, DatabaseImage> known = draft.ReadImages();
  const std::map<ImageId, DatabaseImage> images = view.ReadImages();
  Database::Transaction transaction(draft);
  for (const auto& [id, camera] : view.ReadCameras()) {
    if (cameras.count(id) == 0) transaction.InsertCamera(id, camera);
  }
  for (const auto& [name, id] : photos) {
    if (known.count(id) == 0) transaction.InsertImage(id, images.at(id));
  }
  transaction.Commit();
}

}  // namespace

void AddPhotos(const PhotoCatalog& catalog, const std::optional<Camera>& given_camera,
               const UpdateDatabase& databases) {
  const DatabaseView view(databases);
  const std::map<ImageId, DatabaseImage> images = view.ReadImages();
  std::map<CameraId, DatabaseCamera> cameras = view.ReadCameras();
  std::set<std::string> known;
  for (const auto& [id, image] : images) known.insert(image.name);
  ImageId next_id = images.empty() ? 1 : images.rbegin()->first + 1;
  Database draft = Database::Open(databases.draft(), Database::Access::kReadWrite);
  Database::Transaction transaction(draft);
  for (const auto& [id, camera] : cameras) transaction.InsertCamera(id, camera);
  CameraChooser chooser(catalog, given_camera, images, std::move(cameras), &transaction);
  for (const CatalogPhoto& photo : catalog.photos) {
    if (known.count(photo.name) > 0) continue;
    transaction.InsertImage(next_id++, {photo.name, chooser.For(photo), PriorOf(photo)});
  }
  transaction.Commit();
}

void ExtractFeatures(const PhotoCatalog& catalog, const fs::path& image_path,
                     const UpdateDatabase& databases, const fs::path& log_path,
                     const SparseUpdateOptions& options, ColmapProgram* colmap,
                     const JobControl& job) {
  const std::map<std::string, ImageId> photos =
      PhotosWithoutFeatures(catalog, DatabaseView(databases));
  if (photos.empty()) return;
  AddRowsToDraft(photos, databases);
  std::vector<std::string> names;
  for (const auto& [name, id] : photos) names.push_back(name);
  job.Info("features of " + std::to_string(names.size()) + " photos");
  RequireReadablePhotos(names, image_path, job);
  std::string list;
  for (const std::string& name : names) list += name + "\n";
  const fs::path list_path = log_path.parent_path() / "new_photos.txt";
  WriteFileAtomically(list_path, list);
  colmap->Run("feature_extractor",
              {{"database_path", databases.draft().string()},
               {"image_path", image_path.string()},
               {"image_list_path", list_path.string()},
               {"SiftExtraction.use_gpu", "0"},
               {"SiftExtraction.first_octave", std::to_string(options.first_octave)},
               {"SiftExtraction.max_num_features", std::to_string(options.max_num_features)},
               {"SiftExtraction.max_image_size", std::to_string(options.max_image_size)}},
              log_path, job);
  fs::remove(list_path);
  const std::map<std::string, ImageId> left =
      PhotosWithoutFeatures(catalog, DatabaseView(databases));
  if (!left.empty()) {
    throw Error(
        (image_path / left.begin()->first).string() +
        ": `colmap feature_extractor` could not read this photo; its output: " + log_path.string());
  }
}

}  // namespace colmap_ext
