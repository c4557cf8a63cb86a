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
};

struct PhotoCatalog {
  std::vector<CatalogPhoto> photos;  // sorted by name
  // Frame of the positions: ENU at this origin, or absent: local metres, or no positions at all.
  std::optional<GeoPosition> origin;
  int num_positions = 0;
};

// Reads the folder and the metadata of its photos. The origin is that of `input.frame`, else the
// first photo's. Throws Error when the folder has fewer than 3 photos, or a given file of positions
// names none of them.
PhotoCatalog ReadCatalog(const SparseUpdateInput& input, const JobControl& job);

// Camera for a photo of which only EXIF speaks: SIMPLE_RADIAL, focal length from EXIF or 1.2 times
// the longer side, as COLMAP guesses it.
Camera GuessCamera(const PhotoMetadata& metadata);

// Photos with the same text were taken by one camera: size, make, model and focal length agree.
std::string CameraKey(const PhotoMetadata& metadata);

}  // namespace colmap_ext
