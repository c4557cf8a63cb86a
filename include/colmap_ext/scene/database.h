// COLMAP's SQLite database: cameras, photos, keypoints, descriptors, matches. Reads and edits, in
// transactions, databases of 3.8 to 4.x, each in its own schema. Tables:
// https://colmap.github.io/database.html
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/scene/rig.h"

namespace colmap_ext {

inline constexpr ImageId kMaxImageId = 2147483646;  // COLMAP's limit; ids begin at 1

struct DatabaseCamera {
  Camera camera;
  bool has_prior_focal_length = false;  // the focal length is known, not guessed
};

// What the numbers of a position prior mean.
enum class PriorFrame {
  kUnknown = -1,   // the 3.8 schema does not say; feature_extractor writes GPS
  kWgs84 = 0,      // latitude and longitude in degrees, altitude in metres
  kCartesian = 1,  // metres
};

struct PositionPrior {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  PriorFrame frame = PriorFrame::kUnknown;
};

struct DatabaseImage {
  std::string name;  // relative to the image folder
  CameraId camera_id = 0;
  std::optional<PositionPrior> prior;
};

// One row a keypoint: x, y (COLMAP's pixel convention), then nothing (2 columns), scale and
// orientation (4), or an affine shape (6).
using KeypointMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
// One row a keypoint; SIFT has 128 columns.
using DescriptorMatrix =
    Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Keypoint indices in the first and in the second photo of a pair.
using KeypointMatch = std::pair<std::uint32_t, std::uint32_t>;

// Two different photos. Functions take either order, and give matches and geometry in that order;
// results list pairs with first < second.
using ImagePair = std::pair<ImageId, ImageId>;

// COLMAP's key of a pair, the same for both orders: 2147483647 * smaller + larger. Throws Error for
// ids that are 0, too large, or equal.
std::uint64_t PairIdOf(const ImagePair& pair);
// The pair with first < second. Throws Error for a number that is no pair's key.
ImagePair PairOfId(std::uint64_t pair_id);

// How two photos are related (COLMAP's TwoViewGeometry::ConfigurationType).
enum class TwoViewConfig {
  kUndefined = 0,
  kDegenerate = 1,  // verification failed: too few inliers
  kCalibrated = 2,
  kUncalibrated = 3,
  kPlanar = 4,
  kPanoramic = 5,
  kPlanarOrPanoramic = 6,
  kWatermark = 7,
  kMultiple = 8,
  kCalibratedRig = 9,  // 3.12 and later
};

struct TwoViewGeometry {
  TwoViewConfig config = TwoViewConfig::kUndefined;
  std::vector<KeypointMatch> inlier_matches;
  // x2ᵀ F x1 = 0 in pixels, the same for E on the normalised plane, x2 ~ H x1; zero when unknown.
  Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d E = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  std::optional<Rigid3d> cam2_from_cam1;  // scale free; absent where the database has none
};

struct TwoViewSummary {
  TwoViewConfig config = TwoViewConfig::kUndefined;
  std::size_t num_inliers = 0;
};

// Every function throws Error naming the file when SQLite reports corruption, a lock that another
// program holds, or a full disk, and when a row contradicts itself (a blob of the wrong size).
class Database {
 public:
  class Transaction;
  enum class Access {
    kReadOnly,  // leaves no trace in the folder, unless another program is writing
    kReadWrite,
  };

  // Throws Error naming the file when it is missing, truncated, no SQLite database, or has not
  // COLMAP's tables and columns.
  static Database Open(const std::filesystem::path& path, Access access);
  // An empty database of the 3.8 schema, as `colmap database_creator` makes it. Appears complete or
  // not at all. Throws Error when `path` exists.
  static Database Create(const std::filesystem::path& path);
  // Copies what is committed in `from`, also when its newest part is still in a -wal file beside
  // it. Throws Error when `to` exists.
  static void Copy(const std::filesystem::path& from, const std::filesystem::path& to);

  Database(Database&&) noexcept;
  Database& operator=(Database&&) noexcept;
  ~Database();

  const std::filesystem::path& path() const;
  // COLMAP's stamp of its schema: 3800 for 3.8, 3900 for 3.9 and 3.10, 4020100 for 4.2.1; 0 for
  // databases made by scripts.
  int user_version() const;
  // Whether photos belong to rigs and frames here (COLMAP 3.12 and later).
  bool has_frames() const;

  // Throws Error naming file and id for a camera model that we do not know.
  std::map<CameraId, DatabaseCamera> ReadCameras() const;
  std::map<ImageId, DatabaseImage> ReadImages() const;
  std::optional<ImageId> FindImage(const std::string& name) const;
  // Rigs and frames; empty in a schema that has none. Throws Error when the table is not sound.
  FrameTable ReadFrameTable() const;

  // Number of keypoints of every photo whose features were extracted.
  std::map<ImageId, std::size_t> NumKeypoints() const;
  // 0 rows when nothing was extracted for that photo.
  KeypointMatrix ReadKeypoints(ImageId image_id) const;
  DescriptorMatrix ReadDescriptors(ImageId image_id) const;

  // Number of matches of every pair that was matched, 0 for pairs that were tried in vain.
  std::map<ImagePair, std::size_t> NumMatches() const;
  // Empty when the pair was not matched.
  std::vector<KeypointMatch> ReadMatches(const ImagePair& pair) const;
  // Every pair that was verified.
  std::map<ImagePair, TwoViewSummary> TwoViewSummaries() const;
  std::optional<TwoViewGeometry> ReadTwoViewGeometry(const ImagePair& pair) const;

 private:
  struct Impl;
  explicit Database(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// The only way to edit a database: all of it or nothing. Holds the write lock from construction, so
// keep it short.
class Database::Transaction {
 public:
  // Waits some seconds for other programs. `database` must outlive this object. Throws Error when
  // it was opened read-only, is locked, or is of a version whose tables we do not know.
  explicit Transaction(Database& database);
  // Undoes everything unless Commit() was called.
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  // Cameras and photos with ids of our choice, before `colmap feature_extractor` runs: it keeps
  // ids, camera and prior of a photo that it finds here by name. Where the schema has rigs and
  // frames, a camera becomes a rig of one sensor and a photo a frame of one photo, with the
  // camera's and the photo's id where these are free. Throw Error when id or name is taken, or the
  // camera is unknown.
  void InsertCamera(CameraId camera_id, const DatabaseCamera& camera);
  void InsertImage(ImageId image_id, const DatabaseImage& image);
  // Replaces size, model and parameters. Throws Error when there is no such camera.
  void UpdateCamera(CameraId camera_id, const DatabaseCamera& camera);
  // Sets or replaces the position prior; the 3.8 schema does not keep the frame. Throws Error when
  // there is no such photo, or the schema has no place for priors.
  void SetPositionPrior(ImageId image_id, const Eigen::Vector3d& position,
                        PriorFrame frame = PriorFrame::kWgs84);

  // Throw Error when the photo or pair has an entry already. No keypoints are stored as 0 x 6,
  // which COLMAP reads.
  void InsertKeypoints(ImageId image_id, const KeypointMatrix& keypoints);
  void InsertDescriptors(ImageId image_id, const DescriptorMatrix& descriptors);
  void InsertMatches(const ImagePair& pair, const std::vector<KeypointMatch>& matches);
  void InsertTwoViewGeometry(const ImagePair& pair, const TwoViewGeometry& geometry);

  void Commit();

 private:
  Impl& impl_;
  bool is_open_ = false;
};

}  // namespace colmap_ext
