// All photos of an update: what is known about each before COLMAP sees it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/sfm/sparse_update.h"

namespace colmap_ext {

struct CatalogPhoto {
  std::string name;
  PhotoMetadata metadata;
  std::optional<GeoPosition> geo;                    // where it was taken, on Earth
  std::optional<Eigen::Vector3d> position_in_world;  // ... in the frame of the catalog, metres
  // Accuracy of the position, one sigma, metres, where its source tells it.
  std::optional<double> sigma_horizontal_m, sigma_vertical_m;
  // The world's z axis in the camera, unit length, where the attitude was measured.
  std::optional<Eigen::Vector3d> up_in_cam;
};

struct PhotoCatalog {
  std::vector<CatalogPhoto> photos;  // sorted by name
  // Frame of the positions: ENU at this origin, or absent: local metres, or no positions at all.
  std::optional<GeoPosition> origin;
  int num_positions = 0;
};

// Reads the folder, the metadata of its photos and the capture journal beside them
// (captures.jsonl). A photo's position is that of the first source that has one: local positions of
// `input`, its geographic ones, the journal, EXIF, the
// database's GPS priors (the last: feature_extractor of 3.8 rounds EXIF's by 0.3 m). The journal's
// attitude wins over EXIF's heading and pitch. The origin is that of `input.frame`, else the first
// photo's. Throws Error when the folder has fewer than 3 photos, a given file of positions names
// none of them, or the journal is damaged.
PhotoCatalog ReadCatalog(const SparseUpdateInput& input, const JobControl& job);

// Camera for a photo of which only EXIF speaks: SIMPLE_RADIAL, focal length from EXIF or 1.2 times
// the longer side, as COLMAP guesses it.
Camera GuessCamera(const PhotoMetadata& metadata);

// Photos with the same text were taken by one camera: size, make, model and focal length agree.
std::string CameraKey(const PhotoMetadata& metadata);

}  // namespace colmap_ext
