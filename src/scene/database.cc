#include "colmap_ext/scene/database.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstring>
#include <limits>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/database_impl.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kPairFactor = 2147483647;
constexpr std::int64_t kMaxRows = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kMaxCameraId = std::numeric_limits<CameraId>::max();

void RequireAbsent(const fs::path& path) {
  if (fs::exists(path)) {
    throw Error(path.string() + ": exists already; choose another name, or open it");
  }
}

// Makes a database by `fill` beside `path`, then renames it: nobody sees half of it.
template <typename Fill>
void CreateAtomically(const fs::path& path, Fill&& fill) {
  RequireAbsent(path);
  if (path.has_parent_path()) RequireWritableFolder(path.parent_path(), "folder of the database");
  const fs::path temporary = TemporaryPathFor(path);
  std::error_code ignored;
  fs::remove(temporary, ignored);
  try {
    SqliteConnection connection(temporary, SqliteConnection::Mode::kCreate);
    // CommitTemporaryFile waits for the disk, once.
    connection.Execute("PRAGMA synchronous = OFF", "create the database");
    fill(connection);
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
  CommitTemporaryFile(temporary, path);
}

// Rows and columns, and a blob that must be as large as they say.
struct MatrixShape {
  std::int64_t rows = 0;
  std::int64_t cols = 0;
};

MatrixShape CheckShape(const SqliteStatement& statement, int rows_column, int data_column,
                       std::size_t element_bytes, const std::string& what) {
  MatrixShape shape{statement.Integer(rows_column, 0, kMaxRows),
                    statement.Integer(rows_column + 1, 0, 4096)};
  const std::size_t wanted =
      static_cast<std::size_t>(shape.rows) * static_cast<std::size_t>(shape.cols) * element_bytes;
  const std::size_t found = statement.Blob(data_column).size();
  if (found != wanted) {
    statement.FailWith(what + " are " + std::to_string(shape.rows) + " x " +
                       std::to_string(shape.cols) + ", " + std::to_string(wanted) + " bytes, but " +
                       std::to_string(found) + " are stored; the database is corrupt");
  }
  return shape;
}

// A matrix of keypoints or descriptors; SQL columns rows, cols, data.
template <typename Matrix>
Matrix ReadMatrix(SqliteStatement& statement, const std::string& what) {
  if (!statement.Step()) return {};
  const MatrixShape shape = CheckShape(statement, 0, 2, sizeof(typename Matrix::Scalar), what);
  Matrix matrix(shape.rows, shape.cols);
  const auto blob = statement.Blob(2);
  if (!blob.empty()) std::memcpy(matrix.data(), blob.data(), blob.size());
  return matrix;
}

// SQL columns rows, cols, data from `rows_column` on.
std::vector<KeypointMatch> MatchesFrom(const SqliteStatement& statement, int rows_column,
                                       const std::string& what) {
  const MatrixShape shape =
      CheckShape(statement, rows_column, rows_column + 2, sizeof(std::uint32_t), what);
  if (shape.rows > 0 && shape.cols != 2) {
    statement.FailWith(what + " have " + std::to_string(shape.cols) +
                       " columns, not 2; the database is corrupt");
  }
  std::vector<KeypointMatch> matches(static_cast<std::size_t>(shape.rows));
  const std::byte* data = statement.Blob(rows_column + 2).data();
  for (KeypointMatch& match : matches) {
    std::memcpy(&match.first, data, 4);
    std::memcpy(&match.second, data + 4, 4);
    data += 8;
  }
  return matches;
}

// Matrices are stored row by row; NULL and empty mean unknown (all zero).
template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> FixedMatrixFrom(const SqliteStatement& statement, int column,
                                                  const std::string& what) {
  Eigen::Matrix<double, Cols, Rows> transposed = Eigen::Matrix<double, Cols, Rows>::Zero();
  const auto blob = statement.Blob(column);
  if (!blob.empty()) {
    if (blob.size() != sizeof(double) * Rows * Cols) {
      statement.FailWith(what + " has a geometry of " + std::to_string(blob.size()) +
                         " bytes; the database is corrupt");
    }
    std::memcpy(transposed.data(), blob.data(), blob.size());
  }
  return transposed.transpose();
}

TwoViewConfig ConfigFrom(const SqliteStatement& statement, int column) {
  return static_cast<TwoViewConfig>(
      statement.Integer(column, static_cast<int>(TwoViewConfig::kUndefined),
                        static_cast<int>(TwoViewConfig::kCalibratedRig)));
}

std::optional<PositionPrior> PriorFromColumns(const SqliteStatement& statement, int first_column) {
  PositionPrior prior;
  for (int axis = 0; axis < 3; ++axis) {
    if (statement.IsNull(first_column + axis)) return std::nullopt;
    prior.position[axis] = statement.Real(first_column + axis);
  }
  return prior;
}

// SQL columns position (three doubles) and coordinate system.
std::optional<PositionPrior> PriorFromBlob(const SqliteStatement& statement, int first_column) {
  if (statement.IsNull(first_column)) return std::nullopt;
  PositionPrior prior;
  prior.position = FixedMatrixFrom<3, 1>(statement, first_column, "a pose prior");
  if (!prior.position.allFinite()) return std::nullopt;
  prior.frame = static_cast<PriorFrame>(statement.Integer(first_column + 1, -1, 1));
  return prior;
}

ImagePair PairFrom(const SqliteStatement& statement, int column) {
  try {
    return PairOfId(static_cast<std::uint64_t>(statement.Integer(column)));
  } catch (const Error& error) {
    statement.FailWith(std::string(error.what()) + "; the database is corrupt");
  }
}

}  // namespace

std::uint64_t PairIdOf(const ImagePair& pair) {
  const auto [small, large] = std::minmax(pair.first, pair.second);
  if (small == 0 || large > kMaxImageId || small == large) {
    throw Error(NameOfPair(pair) + " are no pair (ids are 1 to " + std::to_string(kMaxImageId) +
                " and different)");
  }
  return kPairFactor * small + large;
}

ImagePair PairOfId(std::uint64_t pair_id) {
  const ImagePair pair(static_cast<ImageId>(pair_id / kPairFactor),
                       static_cast<ImageId>(pair_id % kPairFactor));
  if (pair_id / kPairFactor > kMaxImageId || pair.first == 0 || pair.first >= pair.second) {
    throw Error("pair id " + std::to_string(pair_id) + " is no pair of images");
  }
  return pair;
}

void SwapMatches(std::vector<KeypointMatch>* matches) {
  for (KeypointMatch& match : *matches) std::swap(match.first, match.second);
}

void InvertGeometry(TwoViewGeometry* geometry) {
  SwapMatches(&geometry->inlier_matches);
  geometry->F.transposeInPlace();
  geometry->E.transposeInPlace();
  if (!geometry->H.isZero(0)) {
    bool is_invertible = false;
    Eigen::Matrix3d inverse;
    geometry->H.computeInverseWithCheck(inverse, is_invertible, 1e-300);
    if (!is_invertible) throw Error("a homography between two photos has no inverse");
    geometry->H = inverse;
  }
  if (geometry->cam2_from_cam1) geometry->cam2_from_cam1 = Inverse(*geometry->cam2_from_cam1);
}

Database::Database(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Database::Database(Database&&) noexcept = default;
Database& Database::operator=(Database&&) noexcept = default;
Database::~Database() = default;

Database Database::Open(const fs::path& path, Access access) {
  CheckSqliteFile(path);
  if (access == Access::kReadOnly) {
    return Database(std::make_unique<Impl>(path, SqliteConnection::Mode::kReadOnly));
  }
  auto impl = std::make_unique<Impl>(path, SqliteConnection::Mode::kReadWrite);
  impl->connection.Execute("PRAGMA foreign_keys = ON", "open the database");
  return Database(std::move(impl));
}

Database Database::Create(const fs::path& path) {
  CreateAtomically(path, [](SqliteConnection& connection) {
    connection.Execute(CreateSchema38(), "create the database");
  });
  return Open(path, Access::kReadWrite);
}

void Database::Copy(const fs::path& from, const fs::path& to) {
  const Database source = Open(from, Access::kReadOnly);
  CreateAtomically(to, [&](SqliteConnection& target) { source.impl_->connection.CopyTo(target); });
}

const fs::path& Database::path() const { return impl_->connection.path(); }
int Database::user_version() const { return impl_->schema.user_version; }
bool Database::has_frames() const { return impl_->schema.has_frames; }

std::map<CameraId, DatabaseCamera> Database::ReadCameras() const {
  SqliteStatement statement(
      impl_->connection,
      "SELECT camera_id, model, width, height, params, prior_focal_length FROM cameras",
      "read the cameras");
  std::map<CameraId, DatabaseCamera> cameras;
  while (statement.Step()) {
    const auto id = static_cast<CameraId>(statement.Integer(0, 0, kMaxCameraId));
    const std::string name = "camera " + std::to_string(id);
    const CameraModelInfo* info = nullptr;
    try {
      info = &GetCameraModelInfo(static_cast<int>(statement.Integer(1, -kMaxRows, kMaxRows)));
    } catch (const Error& error) {
      statement.FailWith(name + ": " + error.what());
    }
    DatabaseCamera& entry = cameras[id];
    entry.camera.model = info->model;
    entry.camera.width = static_cast<int>(statement.Integer(2, 1, kMaxRows));
    entry.camera.height = static_cast<int>(statement.Integer(3, 1, kMaxRows));
    const auto blob = statement.Blob(4);
    entry.camera.params.resize(static_cast<std::size_t>(info->num_params));
    if (blob.size() != entry.camera.params.size() * sizeof(double)) {
      statement.FailWith(name + " has " + std::to_string(blob.size() / sizeof(double)) +
                         " parameters, not the " + std::to_string(info->num_params) + " of " +
                         info->name + "; the database is corrupt");
    }
    std::memcpy(entry.camera.params.data(), blob.data(), blob.size());
    entry.has_prior_focal_length = statement.Integer(5) != 0;
  }
  return cameras;
}

std::map<ImageId, DatabaseImage> Database::ReadImages() const {
  SqliteStatement statement(impl_->connection, impl_->schema.SelectImages(), "read the images");
  std::map<ImageId, DatabaseImage> images;
  while (statement.Step()) {
    DatabaseImage& image = images[static_cast<ImageId>(statement.Integer(0, 0, kMaxImageId))];
    image.name = statement.Text(1);
    image.camera_id = static_cast<CameraId>(statement.Integer(2, 0, kMaxCameraId));
    switch (impl_->schema.prior_layout) {
      case PriorLayout::kNone:
        break;
      case PriorLayout::kImageColumns:
        image.prior = PriorFromColumns(statement, 3);
        break;
      case PriorLayout::kTableByImage:
      case PriorLayout::kTableByData:
        image.prior = PriorFromBlob(statement, 3);
        break;
    }
  }
  return images;
}

std::optional<ImageId> Database::FindImage(const std::string& name) const {
  SqliteStatement statement(impl_->connection, "SELECT image_id FROM images WHERE name = ?",
                            "find an image");
  statement.Bind(name);
  if (!statement.Step()) return std::nullopt;
  return static_cast<ImageId>(statement.Integer(0, 0, kMaxImageId));
}

FrameTable Database::ReadFrameTable() const {
  if (!impl_->schema.has_frames) return {};
  FrameTable table = ReadFrameTableRows(impl_->connection);
  const std::string problem = ProblemOf(table);
  if (!problem.empty()) impl_->connection.FailWith(problem + "; the database is corrupt");
  return table;
}

std::map<ImageId, std::size_t> Database::NumKeypoints() const {
  SqliteStatement statement(impl_->connection, "SELECT image_id, rows FROM keypoints",
                            "count the keypoints");
  std::map<ImageId, std::size_t> counts;
  while (statement.Step()) {
    counts[static_cast<ImageId>(statement.Integer(0, 0, kMaxImageId))] =
        static_cast<std::size_t>(statement.Integer(1, 0, kMaxRows));
  }
  return counts;
}

KeypointMatrix Database::ReadKeypoints(ImageId image_id) const {
  SqliteStatement statement(impl_->connection,
                            "SELECT rows, cols, data FROM keypoints WHERE image_id = ?",
                            "read keypoints");
  statement.Bind(static_cast<std::int64_t>(image_id));
  const std::string what = "keypoints of image " + std::to_string(image_id);
  KeypointMatrix keypoints = ReadMatrix<KeypointMatrix>(statement, what);
  const Eigen::Index cols = keypoints.cols();
  if (keypoints.rows() > 0 && cols != 2 && cols != 4 && cols != 6) {
    statement.FailWith(what + " have " + std::to_string(cols) +
                       " columns, not 2, 4 or 6; the database is corrupt");
  }
  return keypoints;
}

DescriptorMatrix Database::ReadDescriptors(ImageId image_id) const {
  SqliteStatement statement(impl_->connection,
                            "SELECT rows, cols, data FROM descriptors WHERE image_id = ?",
                            "read descriptors");
  statement.Bind(static_cast<std::int64_t>(image_id));
  return ReadMatrix<DescriptorMatrix>(statement,
                                      "descriptors of image " + std::to_string(image_id));
}

std::map<ImagePair, std::size_t> Database::NumMatches() const {
  SqliteStatement statement(impl_->connection, "SELECT pair_id, rows FROM matches",
                            "count the matches");
  std::map<ImagePair, std::size_t> counts;
  while (statement.Step()) {
    counts[PairFrom(statement, 0)] = static_cast<std::size_t>(statement.Integer(1, 0, kMaxRows));
  }
  return counts;
}

std::vector<KeypointMatch> Database::ReadMatches(const ImagePair& pair) const {
  SqliteStatement statement(
      impl_->connection, "SELECT rows, cols, data FROM matches WHERE pair_id = ?", "read matches");
  statement.Bind(static_cast<std::int64_t>(PairIdOf(pair)));
  if (!statement.Step()) return {};
  auto matches = MatchesFrom(statement, 0, "matches of " + NameOfPair(pair));
  if (IsSwapped(pair)) SwapMatches(&matches);
  return matches;
}

std::map<ImagePair, TwoViewSummary> Database::TwoViewSummaries() const {
  SqliteStatement statement(impl_->connection,
                            "SELECT pair_id, config, rows FROM two_view_geometries",
                            "read the two-view geometries");
  std::map<ImagePair, TwoViewSummary> summaries;
  while (statement.Step()) {
    summaries[PairFrom(statement, 0)] = {
        ConfigFrom(statement, 1), static_cast<std::size_t>(statement.Integer(2, 0, kMaxRows))};
  }
  return summaries;
}

std::optional<TwoViewGeometry> Database::ReadTwoViewGeometry(const ImagePair& pair) const {
  const DatabaseSchema& schema = impl_->schema;
  SqliteStatement statement(impl_->connection,
                            "SELECT config, rows, cols, data, " + schema.f_column + ", " +
                                schema.e_column + ", " + schema.h_column + ", " +
                                schema.qvec_column + ", " + schema.tvec_column +
                                " FROM two_view_geometries WHERE pair_id = ?",
                            "read a two-view geometry");
  statement.Bind(static_cast<std::int64_t>(PairIdOf(pair)));
  if (!statement.Step()) return std::nullopt;
  const std::string what = "inlier matches of " + NameOfPair(pair);
  TwoViewGeometry geometry;
  geometry.config = ConfigFrom(statement, 0);
  geometry.inlier_matches = MatchesFrom(statement, 1, what);
  geometry.F = FixedMatrixFrom<3, 3>(statement, 4, what);
  geometry.E = FixedMatrixFrom<3, 3>(statement, 5, what);
  geometry.H = FixedMatrixFrom<3, 3>(statement, 6, what);
  const Eigen::Vector4d q = FixedMatrixFrom<4, 1>(statement, 7, what);
  const Eigen::Vector3d t = FixedMatrixFrom<3, 1>(statement, 8, what);
  // Zero (3.8) or the identity (3.9 and later): COLMAP did not estimate the pose.
  const bool is_identity = q == Eigen::Vector4d::UnitX() && t.isZero(0);
  if (q.norm() > 0.5 && !is_identity) {
    geometry.cam2_from_cam1 = Rigid3d{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), t};
  }
  if (IsSwapped(pair)) InvertGeometry(&geometry);
  return geometry;
}

}  // namespace colmap_ext
