#include "photo_catalog.h"

#include <algorithm>
#include <cmath>

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

void SetGeoPositions(const SparseUpdateInput& input, PhotoCatalog* catalog) {
  for (CatalogPhoto& photo : catalog->photos) {
    const auto given = input.geo_position_of_photo.find(photo.name);
    photo.geo = given != input.geo_position_of_photo.end() ? given->second : photo.metadata.gps;
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
  SetGeoPositions(input, &catalog);
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
