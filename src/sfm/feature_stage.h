// Photos into the database: cameras and photos with ids that follow the names, then features.
#pragma once

#include <filesystem>
#include <optional>

#include "colmap_ext/sfm/colmap_program.h"
#include "photo_catalog.h"
#include "update_database.h"

namespace colmap_ext {

// Adds a camera and an image row to the draft for every photo that the database does not have; ids
// go on from the largest one in name order. Throws Error when a photo has not the size of the given
// camera.
void AddPhotos(const PhotoCatalog& catalog, const std::optional<Camera>& given_camera,
               const UpdateDatabase& databases);

// Extracts the features of the photos that have none into the draft. Throws Error naming a photo
// that cannot be read.
void ExtractFeatures(const PhotoCatalog& catalog, const std::filesystem::path& image_path,
                     const UpdateDatabase& databases, const std::filesystem::path& log_path,
                     const SparseUpdateOptions& options, ColmapProgram* colmap,
                     const JobControl& job);

}  // namespace colmap_ext
