// Photos into the database: cameras and photos with ids that follow the names, then features.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "photo_catalog.h"

namespace colmap_ext {

// A copy of the database beside it that replaces it when everything is done.
class WorkingDatabase {
 public:
  // A copy of `database_path`, else of `base_path` when given, else a new database. Throws Error
  // when the database was made by a COLMAP that does not go with the program in use.
  WorkingDatabase(const std::filesystem::path& database_path,
                  const std::filesystem::path& base_path, const std::filesystem::path& work_path,
                  ColmapProgram* colmap, const JobControl& job);
  ~WorkingDatabase();  // removes the copy unless Commit() was called
  WorkingDatabase(const WorkingDatabase&) = delete;
  WorkingDatabase& operator=(const WorkingDatabase&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // An empty database as the program in use makes it.
  const std::filesystem::path& empty_database() const { return empty_; }
  void Commit();

 private:
  std::filesystem::path target_, path_, empty_;
};

// Adds a camera and an image row for every photo that the database does not have; ids go on from
// the largest one in name order. Returns the names that were added. Throws Error when a photo has
// not the size of the given camera.
std::vector<std::string> AddPhotos(const PhotoCatalog& catalog,
                                   const std::optional<Camera>& given_camera, Database* database);

// Extracts the features of the photos that have none. Throws Error naming a photo that cannot be
// read.
void ExtractFeatures(const PhotoCatalog& catalog, const std::filesystem::path& image_path,
                     const std::filesystem::path& database_path,
                     const std::filesystem::path& log_path, const SparseUpdateOptions& options,
                     ColmapProgram* colmap, const JobControl& job);

}  // namespace colmap_ext
