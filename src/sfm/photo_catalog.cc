#include "photo_catalog.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/database.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// Fewer photos cannot be checked against each other: two always fit.
constexpr std::size_t kMinPhotos = 3;

template <typename Position>
void RequireSomeName(const std::map<std::string, Position>& positions,
                     const std::vector<CatalogPhoto>& photos,
                     const std::filesystem::path& image_path) {
  if (positions.empty()) return;
  for (const CatalogPhoto& photo : photos) {
    if (positions.count(photo.name) > 0) return;
  }
  throw Error("the given positions name none of the photos in " + image_path.string() +
              " (first position: \"" + positions.begin()->first + "\", first photo: \"" +
              photos.front().name + "\")");
}

std::vector<std::string> ListEnoughPhotos(const std::filesystem::path& image_path) {
  RequireFolder(image_path, "image folder");
  const std::vector<std::string> names = ListPhotos(image_path);
  if (names.empty()) {
    throw Error(image_path.string() +
                ": no photos (.jpg, .jpeg, .png, .tif, .tiff) in this folder");
  }
  if (names.size() < kMinPhotos) {
    throw Error(image_path.string() + ": only " + std::to_string(names.size()) +
                (names.size() == 1 ? " photo (" : " photos (") + names.front() +
                (names.size() == 1 ? "" : ", " + names.back()) +
                "); at least 3 that overlap are needed");
  }
  return names;
}

using Captures = std::map<std::string, CaptureRecord>;

Captures ReadCaptures(const std::filesystem::path& image_path) {
  const std::filesystem::path path = image_path / "captures.jsonl";
  return std::filesystem::exists(path) ? ReadCaptureJournal(path) : Captures();
}

void TakeAttitude(const CaptureRecord& capture, CatalogPhoto* photo) {
  if (!capture.cam_from_enu) return;
  photo->up_in_cam = *capture.cam_from_enu * Eigen::Vector3d::UnitZ();
  const ViewDirection direction = ViewDirectionOf({*capture.cam_from_enu, Eigen::Vector3d::Zero()});
  photo->metadata.yaw_rad = direction.yaw_rad;
  photo->metadata.pitch_rad = direction.pitch_rad;
}

// The world's z axis in a camera whose gimbal told all three angles.
std::optional<Eigen::Vector3d> UpInCam(const PhotoMetadata& metadata) {
  if (!metadata.yaw_rad || !metadata.pitch_rad || !metadata.roll_rad) return std::nullopt;
  const double pitch = *metadata.pitch_rad, roll = *metadata.roll_rad;
  return Eigen::Vector3d(-std::sin(roll) * std::cos(pitch), -std::cos(roll) * std::cos(pitch),
                         std::sin(pitch));
}

// GPS of the database that is there already, by photo; another frame than WGS84 tells no place on
// Earth.
std::map<std::string, GeoPosition> ReadDatabasePriors(const SparseUpdateInput& input) {
  const std::filesystem::path& path =
      input.base_database_path.empty() ? input.database_path : input.base_database_path;
  std::map<std::string, GeoPosition> positions;
  if (!std::filesystem::is_regular_file(path)) return positions;
  const Database database = Database::Open(path, Database::Access::kReadOnly);
  for (const auto& [id, image] : database.ReadImages()) {
    if (!image.prior || image.prior->frame == PriorFrame::kCartesian) continue;
    const Eigen::Vector3d& p = image.prior->position;
    const GeoPosition position{.lat_deg = p.x(), .lon_deg = p.y(), .height_m = p.z()};
    if (IsValid(position) && (p.x() != 0 || p.y() != 0)) positions[image.name] = position;
  }
  return positions;
}

void SetGeoPositions(const SparseUpdateInput& input, const Captures& captures,
                     PhotoCatalog* catalog) {
  const std::map<std::string, GeoPosition> priors = ReadDatabasePriors(input);
  for (CatalogPhoto& photo : catalog->photos) {
    const auto given = input.geo_position_of_photo.find(photo.name);
    const auto capture = captures.find(photo.name);
    photo.up_in_cam = UpInCam(photo.metadata);
    if (capture != captures.end()) TakeAttitude(capture->second, &photo);
    if (given != input.geo_position_of_photo.end()) {
      photo.geo = given->second;
    } else if (capture != captures.end()) {
      photo.geo = capture->second.position;
      photo.sigma_horizontal_m = capture->second.sigma_horizontal_m;
      photo.sigma_vertical_m = capture->second.sigma_vertical_m;
    } else {
      const auto prior = priors.find(photo.name);
      photo.geo = photo.metadata.gps;
      photo.sigma_horizontal_m = photo.metadata.gps_sigma_horizontal_m;
      photo.sigma_vertical_m = photo.metadata.gps_sigma_vertical_m;
      if (!photo.geo && prior != priors.end()) photo.geo = prior->second;
    }
    if (photo.geo && !IsValid(*photo.geo)) {
      throw Error(photo.name + ": its position is not on Earth (latitude " +
                  std::to_string(photo.geo->lat_deg) + ", longitude " +
                  std::to_string(photo.geo->lon_deg) + ")");
    }
  }
}

// Photos to metres around one origin.
void PlaceOnEarth(const SparseUpdateInput& input, PhotoCatalog* catalog) {
  catalog->origin = input.frame.origin;
  for (CatalogPhoto& photo : catalog->photos) {
    if (!photo.geo) continue;
    if (!catalog->origin) catalog->origin = photo.geo;
    photo.position_in_world = EnuFromGeo(*catalog->origin, *photo.geo);
  }
}

void PlaceLocally(const SparseUpdateInput& input, PhotoCatalog* catalog) {
  for (CatalogPhoto& photo : catalog->photos) {
    const auto found = input.local_position_of_photo.find(photo.name);
    photo.sigma_horizontal_m = photo.sigma_vertical_m = std::nullopt;  // of another source
    if (found != input.local_position_of_photo.end()) photo.position_in_world = found->second;
  }
}

}  // namespace

PhotoCatalog ReadCatalog(const SparseUpdateInput& input, const JobControl& job) {
  const std::vector<std::string> names = ListEnoughPhotos(input.image_path);
  job.ThrowIfCancelled();
  const std::map<std::string, PhotoMetadata> metadata = ReadFolderMetadata(input.image_path);
  PhotoCatalog catalog;
  for (const std::string& name : names) {
    CatalogPhoto photo;
    photo.name = name;
    const auto found = metadata.find(name);
    if (found == metadata.end()) continue;  // removed meanwhile
    photo.metadata = found->second;
    catalog.photos.push_back(std::move(photo));
  }
  RequireSomeName(input.geo_position_of_photo, catalog.photos, input.image_path);
  RequireSomeName(input.local_position_of_photo, catalog.photos, input.image_path);
  SetGeoPositions(input, ReadCaptures(input.image_path), &catalog);
  if (input.local_position_of_photo.empty()) {
    PlaceOnEarth(input, &catalog);
  } else {
    PlaceLocally(input, &catalog);
  }
  catalog.num_positions = static_cast<int>(
      std::count_if(catalog.photos.begin(), catalog.photos.end(),
                    [](const CatalogPhoto& photo) { return photo.position_in_world.has_value(); }));
  return catalog;
}

Camera GuessCamera(const PhotoMetadata& metadata) {
  constexpr double kGuessedFocalFactor = 1.2;
  const double focal =
      metadata.focal_px.value_or(kGuessedFocalFactor * std::max(metadata.width, metadata.height));
  return {CameraModel::kSimpleRadial,
          metadata.width,
          metadata.height,
          {focal, 0.5 * metadata.width, 0.5 * metadata.height, 0.0}};
}

std::string CameraKey(const PhotoMetadata& metadata) {
  const long tenths = metadata.focal_px ? std::lround(*metadata.focal_px * 10) : 0;
  return std::to_string(metadata.width) + "x" + std::to_string(metadata.height) + "/" +
         metadata.camera_make + "/" + metadata.camera_model + "/" + std::to_string(tenths);
}

}  // namespace colmap_ext
