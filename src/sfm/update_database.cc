#include "update_database.h"

#include <string>

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
  for (const char* suffix : {"-wal", "-journal"}) {
    const fs::path log = Beside(database, suffix);
    if (fs::exists(log) && fs::file_size(log) > 0) return true;
  }
  return false;
}

// Each photo is placed for itself here.
void RequireSingleCameraRigs(const fs::path& path, const Database& database) {
  for (const auto& [id, rig] : database.ReadFrameTable().rigs) {
    for (const auto& [sensor, pose] : rig.sensor_from_rig) {
      if (sensor.type != SensorType::kCamera) continue;
      throw Error(path.string() + ": rig " + std::to_string(id) +
                  " has several cameras; models of such rigs are continued by `colmap mapper`, or "
                  "make a database without rigs");
    }
  }
}

// Databases without frames (until 3.11) and with frames do not mix: COLMAP would lose priors and
// crash. A stamp of 0 stands for a database made by a script, with 3.8's tables.
void RequireMatchingVersion(const fs::path& path, const Database& database, const Database& empty,
                            const std::string& program_name) {
  RequireSingleCameraRigs(path, database);
  if (database.user_version() <= empty.user_version() &&
      database.has_frames() == empty.has_frames()) {
    return;
  }
  throw Error(path.string() + ": this database was made by another version of COLMAP (stamp " +
              std::to_string(database.user_version()) + ") than the program in use (" +
              program_name + ", stamp " + std::to_string(empty.user_version()) +
              "); name that version's program by --colmap_path, or start a new database");
}

const fs::path& RequireParentFolder(const fs::path& database_path) {
  RequireWritableFolder(fs::absolute(database_path).parent_path(), "folder of the database");
  return database_path;
}

void AddMissingRows(const Database& from, const Database& to, Database::Transaction* transaction) {
  const std::map<CameraId, DatabaseCamera> cameras = to.ReadCameras();
  for (const auto& [id, camera] : from.ReadCameras()) {
    if (cameras.count(id) == 0) transaction->InsertCamera(id, camera);
  }
  const std::map<ImageId, DatabaseImage> images = to.ReadImages();
  for (const auto& [id, image] : from.ReadImages()) {
    if (images.count(id) == 0) transaction->InsertImage(id, image);
  }
}

void AddMissingFeatures(const Database& from, const Database& to,
                        Database::Transaction* transaction) {
  const std::map<ImageId, std::size_t> counts = to.NumKeypoints();
  for (const auto& [id, count] : from.NumKeypoints()) {
    if (counts.count(id) > 0) continue;
    transaction->InsertKeypoints(id, from.ReadKeypoints(id));
    transaction->InsertDescriptors(id, from.ReadDescriptors(id));
  }
}

void AddMissingPairs(const Database& from, const Database& to, Database::Transaction* transaction) {
  const std::map<ImagePair, std::size_t> matched = to.NumMatches();
  for (const auto& [pair, count] : from.NumMatches()) {
    if (matched.count(pair) == 0) transaction->InsertMatches(pair, from.ReadMatches(pair));
  }
  const std::map<ImagePair, TwoViewSummary> verified = to.TwoViewSummaries();
  for (const auto& [pair, summary] : from.TwoViewSummaries()) {
    if (verified.count(pair) > 0) continue;
    transaction->InsertTwoViewGeometry(pair, *from.ReadTwoViewGeometry(pair));
  }
}

}  // namespace

UpdateDatabase::UpdateDatabase(const fs::path& database_path, const fs::path& base_path,
                               const fs::path& work_path, ColmapProgram* colmap,
                               const JobControl& job)
    : lock_(RequireParentFolder(database_path)),
      target_(database_path),
      kept_(WorkingPathFor(database_path)),
      draft_(work_path / "draft.db"),
      empty_(work_path / "empty.db") {
  for (const fs::path& path : {kept_, draft_, empty_}) RemoveDatabase(path);
  colmap->Run("database_creator", {{"database_path", empty_.string()}}, work_path / "database.log",
              job);
  Database::Copy(empty_, draft_);
  fs::path source = empty_;
  if (fs::exists(target_)) {
    // Opening and closing brings what a killed program left beside it into the database.
    if (HasPendingWrites(target_)) Database::Open(target_, Database::Access::kReadWrite);
    source = target_;
  } else if (!base_path.empty()) {
    RequireFile(base_path, "database");
    source = base_path;
  }
  RequireMatchingVersion(source, Database::Open(source, Database::Access::kReadOnly),
                         Database::Open(empty_, Database::Access::kReadOnly),
                         colmap->dialect().version());
  if (source == target_) {
    kept_ = target_;
  } else {
    Database::Copy(source, kept_);
  }
}

UpdateDatabase::~UpdateDatabase() {
  if (kept_ != target_) RemoveDatabase(kept_);
  RemoveDatabase(draft_);
  RemoveDatabase(empty_);
}

void UpdateDatabase::Commit() {
  if (HasPendingWrites(target_)) {
    throw Error(target_.string() +
                ": another program is writing to this database; close it and run "
                "the same command again");
  }
  {
    const Database draft = Database::Open(draft_, Database::Access::kReadOnly);
    Database kept = Database::Open(kept_, Database::Access::kReadWrite);
    Database::Transaction transaction(kept);
    AddMissingRows(draft, kept, &transaction);
    AddMissingFeatures(draft, kept, &transaction);
    AddMissingPairs(draft, kept, &transaction);
    transaction.Commit();
  }
  if (kept_ == target_) return;
  if (HasPendingWrites(kept_)) Database::Open(kept_, Database::Access::kReadWrite);
  CommitTemporaryFile(kept_, target_);
}

DatabaseView::DatabaseView(const UpdateDatabase& databases)
    : kept_(Database::Open(databases.kept(), Database::Access::kReadOnly)),
      draft_(Database::Open(databases.draft(), Database::Access::kReadOnly)) {}

std::map<CameraId, DatabaseCamera> DatabaseView::ReadCameras() const {
  std::map<CameraId, DatabaseCamera> cameras = kept_.ReadCameras();
  cameras.merge(draft_.ReadCameras());
  return cameras;
}

std::map<ImageId, DatabaseImage> DatabaseView::ReadImages() const {
  std::map<ImageId, DatabaseImage> images = kept_.ReadImages();
  images.merge(draft_.ReadImages());
  return images;
}

std::map<ImageId, std::size_t> DatabaseView::NumKeypoints() const {
  std::map<ImageId, std::size_t> counts = kept_.NumKeypoints();
  counts.merge(draft_.NumKeypoints());
  return counts;
}

KeypointMatrix DatabaseView::ReadKeypoints(ImageId image_id) const {
  KeypointMatrix keypoints = draft_.ReadKeypoints(image_id);
  return keypoints.rows() > 0 ? keypoints : kept_.ReadKeypoints(image_id);
}

DescriptorMatrix DatabaseView::ReadDescriptors(ImageId image_id) const {
  DescriptorMatrix descriptors = draft_.ReadDescriptors(image_id);
  return descriptors.rows() > 0 ? descriptors : kept_.ReadDescriptors(image_id);
}

std::set<ImagePair> DatabaseView::TriedPairs() const {
  std::set<ImagePair> pairs;
  for (const Database* database : {&kept_, &draft_}) {
    for (const auto& [pair, count] : database->NumMatches()) pairs.insert(pair);
    for (const auto& [pair, summary] : database->TwoViewSummaries()) pairs.insert(pair);
  }
  return pairs;
}

std::map<ImagePair, TwoViewSummary> DatabaseView::TwoViewSummaries() const {
  std::map<ImagePair, TwoViewSummary> summaries = kept_.TwoViewSummaries();
  summaries.merge(draft_.TwoViewSummaries());
  return summaries;
}

std::optional<TwoViewGeometry> DatabaseView::ReadTwoViewGeometry(const ImagePair& pair) const {
  std::optional<TwoViewGeometry> geometry = draft_.ReadTwoViewGeometry(pair);
  return geometry ? geometry : kept_.ReadTwoViewGeometry(pair);
}

void FillForMapper(const std::set<ImageId>& images, const UpdateDatabase& databases,
                   const fs::path& path) {
  const DatabaseView view(databases);
  Database draft = Database::Open(path, Database::Access::kReadWrite);
  const std::map<CameraId, DatabaseCamera> cameras = draft.ReadCameras();
  const std::map<ImageId, DatabaseImage> known = draft.ReadImages();
  const std::map<ImageId, std::size_t> with_keypoints = draft.NumKeypoints();
  const std::map<ImagePair, TwoViewSummary> known_pairs = draft.TwoViewSummaries();
  const std::map<ImageId, std::size_t> extracted = view.NumKeypoints();
  Database::Transaction transaction(draft);
  for (const auto& [id, camera] : view.ReadCameras()) {
    if (cameras.count(id) == 0) transaction.InsertCamera(id, camera);
  }
  for (const auto& [id, image] : view.ReadImages()) {
    if (images.count(id) == 0) continue;
    if (known.count(id) == 0) transaction.InsertImage(id, image);
    if (with_keypoints.count(id) == 0 && extracted.count(id) > 0) {
      transaction.InsertKeypoints(id, view.ReadKeypoints(id));
    }
  }
  for (const auto& [pair, summary] : view.TwoViewSummaries()) {
    if (summary.num_inliers < kMinInliers || known_pairs.count(pair) > 0) continue;
    if (images.count(pair.first) == 0 || images.count(pair.second) == 0) continue;
    transaction.InsertTwoViewGeometry(pair, *view.ReadTwoViewGeometry(pair));
  }
  transaction.Commit();
}

}  // namespace colmap_ext
