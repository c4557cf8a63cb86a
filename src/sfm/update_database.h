// The database during an update: what is kept, and a small draft of what the update needs and adds.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/util/job_control.h"
#include "update_lock.h"

namespace colmap_ext {

// COLMAP's programs work on the draft, so that they never load the photos that an update does not
// touch. Holds the lock of the database.
class UpdateDatabase {
 public:
  // Keeps what is in `database_path`, else in `base_path` when given (which is copied, never
  // changed), else nothing. Throws Error when that database was made by a COLMAP that does not go
  // with the program in use, or another update is running.
  UpdateDatabase(const std::filesystem::path& database_path, const std::filesystem::path& base_path,
                 const std::filesystem::path& work_path, ColmapProgram* colmap,
                 const JobControl& job);
  ~UpdateDatabase();  // removes all temporary files
  UpdateDatabase(const UpdateDatabase&) = delete;
  UpdateDatabase& operator=(const UpdateDatabase&) = delete;

  // What is kept; read only, until Commit().
  const std::filesystem::path& kept() const { return kept_; }
  const std::filesystem::path& draft() const { return draft_; }
  // An empty database as the program in use makes it.
  const std::filesystem::path& empty_database() const { return empty_; }

  // Adds what is new in the draft to the database, in one transaction.
  void Commit();

 private:
  UpdateLock lock_;
  std::filesystem::path target_, kept_, draft_, empty_;
};

// Both databases read as one.
class DatabaseView {
 public:
  explicit DatabaseView(const UpdateDatabase& databases);

  const std::filesystem::path& path() const { return kept_.path(); }
  std::map<CameraId, DatabaseCamera> ReadCameras() const;
  std::map<ImageId, DatabaseImage> ReadImages() const;
  std::map<ImageId, std::size_t> NumKeypoints() const;
  KeypointMatrix ReadKeypoints(ImageId image_id) const;
  DescriptorMatrix ReadDescriptors(ImageId image_id) const;
  // Pairs that were matched or verified.
  std::set<ImagePair> TriedPairs() const;
  std::map<ImagePair, TwoViewSummary> TwoViewSummaries() const;
  std::optional<TwoViewGeometry> ReadTwoViewGeometry(const ImagePair& pair) const;

 private:
  Database kept_, draft_;
};

// COLMAP's mapper uses pairs with at least so many inliers (Mapper.min_num_matches).
inline constexpr std::size_t kMinInliers = 15;

// Brings what the mapper reads of these photos into the database at `path` (the draft, or a copy of
// the empty one) where it is not there yet: keypoints, and the verified pairs among them with at
// least kMinInliers.
void FillForMapper(const std::set<ImageId>& images, const UpdateDatabase& databases,
                   const std::filesystem::path& path);

}  // namespace colmap_ext
