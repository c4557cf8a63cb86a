#include <array>
#include <cmath>
#include <limits>

#include "colmap_ext/util/error.h"
#include "scene/database_impl.h"

namespace colmap_ext {
namespace {

// As COLMAP stores them: row by row, the photo of the smaller id first.
std::vector<std::uint32_t> Flatten(const std::vector<KeypointMatch>& matches) {
  std::vector<std::uint32_t> flat;
  flat.reserve(2 * matches.size());
  for (const auto& [first, second] : matches) {
    flat.push_back(first);
    flat.push_back(second);
  }
  return flat;
}

// COLMAP's number of SIFT among the kinds of features.
constexpr int kSiftType = 0;

std::string NameOf(ImageId image_id) { return "image " + std::to_string(image_id); }

std::string NameOfCamera(CameraId camera_id) { return "camera " + std::to_string(camera_id); }

// ---- Cameras.

void RequireSound(const SqliteConnection& connection, CameraId camera_id,
                  const DatabaseCamera& camera) {
  const CameraModelInfo& info = GetCameraModelInfo(static_cast<int>(camera.camera.model));
  if (camera_id != 0 && camera.camera.width > 0 && camera.camera.height > 0 &&
      camera.camera.params.size() == static_cast<std::size_t>(info.num_params)) {
    return;
  }
  connection.FailWith("cannot write " + NameOfCamera(camera_id) +
                      ": its id or size is not > 0, or it has not the " +
                      std::to_string(info.num_params) + " parameters of " + info.name);
}

// Parameters: model, width, height, params, prior_focal_length, camera_id.
void BindCamera(CameraId camera_id, const DatabaseCamera& camera, SqliteStatement* statement) {
  const std::vector<double>& params = camera.camera.params;
  statement->Bind(static_cast<std::int64_t>(camera.camera.model))
      .Bind(static_cast<std::int64_t>(camera.camera.width))
      .Bind(static_cast<std::int64_t>(camera.camera.height))
      .BindBlob(params.data(), params.size() * sizeof(double))
      .Bind(static_cast<std::int64_t>(camera.has_prior_focal_length ? 1 : 0))
      .Bind(static_cast<std::int64_t>(camera_id));
}

// ---- Rigs and frames.

// `wanted` when no row of `table` has it, else the one behind the largest.
std::int64_t FreeId(const SqliteConnection& connection, const std::string& table,
                    const std::string& column, std::int64_t wanted) {
  SqliteStatement statement(connection,
                            "SELECT CASE WHEN EXISTS(SELECT 1 FROM " + table + " WHERE " + column +
                                " = ?1) THEN (SELECT MAX(" + column + ") + 1 FROM " + table +
                                ") ELSE ?1 END",
                            "choose an id in " + table);
  statement.Bind(wanted).Step();
  return statement.Integer(0);
}

// The rig that has this camera; a new one of this camera alone when there is none.
std::int64_t RigOf(const SqliteConnection& connection, CameraId camera_id) {
  const auto id = static_cast<std::int64_t>(camera_id);
  {
    SqliteStatement known(connection,
                          "SELECT rig_id FROM rigs WHERE ref_sensor_type = 0 AND "
                          "ref_sensor_id = ?1 UNION SELECT rig_id FROM rig_sensors WHERE "
                          "sensor_type = 0 AND sensor_id = ?1",
                          "find the rig of " + NameOfCamera(camera_id));
    if (known.Bind(id).Step()) return known.Integer(0);
  }
  const std::int64_t rig_id = FreeId(connection, "rigs", "rig_id", id);
  SqliteStatement(connection,
                  "INSERT INTO rigs(rig_id, ref_sensor_id, ref_sensor_type) VALUES (?, ?, 0)",
                  "insert the rig of " + NameOfCamera(camera_id))
      .Bind(rig_id)
      .Bind(id)
      .Step();
  return rig_id;
}

void InsertFrame(const SqliteConnection& connection, ImageId image_id, CameraId camera_id) {
  const std::int64_t rig_id = RigOf(connection, camera_id);
  const std::int64_t frame_id = FreeId(connection, "frames", "frame_id", image_id);
  const std::string doing = "insert the frame of " + NameOf(image_id);
  SqliteStatement(connection, "INSERT INTO frames(frame_id, rig_id) VALUES (?, ?)", doing)
      .Bind(frame_id)
      .Bind(rig_id)
      .Step();
  SqliteStatement(connection,
                  "INSERT INTO frame_data(frame_id, data_id, sensor_id, sensor_type) "
                  "VALUES (?, ?, ?, 0)",
                  doing)
      .Bind(frame_id)
      .Bind(static_cast<std::int64_t>(image_id))
      .Bind(static_cast<std::int64_t>(camera_id))
      .Step();
}

// ---- Priors.

void RequirePlaceForPrior(const SqliteConnection& connection, const DatabaseSchema& schema,
                          ImageId image_id, const PositionPrior& prior) {
  if (!prior.position.allFinite()) {
    connection.FailWith(NameOf(image_id) + " has a position prior that is no finite number");
  }
  if (schema.prior_layout != PriorLayout::kNone) return;
  connection.FailWith("has no place for position priors (user_version " +
                      std::to_string(schema.user_version) +
                      "); open it once with COLMAP (`colmap database_creator`), which adds it");
}

void SetPriorColumns(const SqliteConnection& connection, ImageId image_id,
                     const Eigen::Vector3d& position) {
  SqliteStatement(connection,
                  "UPDATE images SET prior_tx = ?, prior_ty = ?, prior_tz = ? WHERE image_id = ?",
                  "set the position prior of " + NameOf(image_id))
      .Bind(position.x())
      .Bind(position.y())
      .Bind(position.z())
      .Bind(static_cast<std::int64_t>(image_id))
      .Step();
}

// Columns and their values of a new row in pose_priors. An empty covariance or gravity would be
// read as zero, which is a value; COLMAP writes NaN for an unknown one.
void InsertPriorRow(const SqliteConnection& connection, const DatabaseSchema& schema,
                    ImageId image_id, std::int64_t camera_id, const PositionPrior& prior) {
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  static constexpr std::array<double, 9> kUnknown = {kNan, kNan, kNan, kNan, kNan,
                                                     kNan, kNan, kNan, kNan};
  const bool by_data = schema.prior_layout == PriorLayout::kTableByData;
  std::string columns = "position, coordinate_system, ";
  std::string values = "?, ?, ?";
  columns += by_data ? "corr_data_id, corr_sensor_id, corr_sensor_type" : "image_id";
  if (by_data) values += ", ?, 0";
  if (schema.has_prior_covariance) columns += ", position_covariance";
  if (schema.has_prior_covariance) values += ", ?";
  if (schema.has_prior_gravity) columns += ", gravity";
  if (schema.has_prior_gravity) values += ", ?";
  SqliteStatement statement(connection,
                            "INSERT INTO pose_priors(" + columns + ") VALUES (" + values + ")",
                            "insert the position prior of " + NameOf(image_id));
  statement.BindBlob(prior.position.data(), 3 * sizeof(double))
      .Bind(static_cast<std::int64_t>(prior.frame))
      .Bind(static_cast<std::int64_t>(image_id));
  if (by_data) statement.Bind(camera_id);
  if (schema.has_prior_covariance) statement.BindBlob(kUnknown.data(), sizeof(kUnknown));
  if (schema.has_prior_gravity) statement.BindBlob(kUnknown.data(), 3 * sizeof(double));
  statement.Step();
}

void WritePrior(const SqliteConnection& connection, const DatabaseSchema& schema, ImageId image_id,
                const PositionPrior& prior) {
  SqliteStatement camera(connection, "SELECT camera_id FROM images WHERE image_id = ?",
                         "find " + NameOf(image_id));
  if (!camera.Bind(static_cast<std::int64_t>(image_id)).Step()) {
    connection.FailWith("has no " + NameOf(image_id) + " to set a position prior of");
  }
  if (schema.prior_layout == PriorLayout::kImageColumns) {
    SetPriorColumns(connection, image_id, prior.position);
    return;
  }
  const bool by_data = schema.prior_layout == PriorLayout::kTableByData;
  SqliteStatement(connection,
                  by_data ? "DELETE FROM pose_priors WHERE corr_data_id = ? AND "
                            "corr_sensor_type = 0"
                          : "DELETE FROM pose_priors WHERE image_id = ?",
                  "replace the position prior of " + NameOf(image_id))
      .Bind(static_cast<std::int64_t>(image_id))
      .Step();
  InsertPriorRow(connection, schema, image_id, camera.Integer(0), prior);
}

// ---- Pairs.

// qvec and tvec of a two-view geometry.
class PoseColumns {
 public:
  PoseColumns(const std::optional<Rigid3d>& pose, UnknownGeometry unknown)
      : is_null_(!pose && unknown == UnknownGeometry::kNull) {
    if (!pose && unknown == UnknownGeometry::kZero) return;
    const Rigid3d known = pose.value_or(Rigid3d());
    q_ = {known.rotation.w(), known.rotation.x(), known.rotation.y(), known.rotation.z()};
    t_ = known.translation;
  }

  // This object must stay until the statement has run.
  void BindTo(SqliteStatement* statement) const {
    if (is_null_) {
      statement->BindNull().BindNull();
    } else {
      statement->BindBlob(q_.data(), sizeof(q_)).BindBlob(t_.data(), sizeof(t_));
    }
  }

 private:
  bool is_null_;
  Eigen::Vector4d q_ = Eigen::Vector4d::Zero();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
};

// ---- Features.

template <typename Matrix>
void InsertMatrix(const SqliteConnection& connection, const std::string& table, ImageId image_id,
                  const Matrix& matrix, const std::string& more_column = "") {
  const std::size_t num_bytes =
      static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar);
  SqliteStatement(connection,
                  "INSERT INTO " + table + "(image_id, rows, cols, data" +
                      (more_column.empty() ? "" : ", " + more_column) + ") VALUES (?, ?, ?, ?" +
                      (more_column.empty() ? ")" : ", " + std::to_string(kSiftType) + ")"),
                  "insert the " + table + " of " + NameOf(image_id))
      .Bind(static_cast<std::int64_t>(image_id))
      .Bind(static_cast<std::int64_t>(matrix.rows()))
      .Bind(static_cast<std::int64_t>(matrix.cols()))
      .BindBlob(matrix.data(), num_bytes)
      .Step();
}

}  // namespace

Database::Transaction::Transaction(Database& database) : impl_(*database.impl_) {
  const std::string complaint = impl_.schema.WhyNotEditable();
  if (!complaint.empty()) impl_.connection.FailWith(complaint);
  // Asked here because SQLite would complain only at the first edit.
  if (impl_.connection.IsReadOnly()) {
    impl_.connection.FailWith("cannot be edited: it is open for reading only, or write-protected");
  }
  impl_.connection.Execute("BEGIN IMMEDIATE", "begin to edit the database");
  is_open_ = true;
}

Database::Transaction::~Transaction() {
  if (!is_open_) return;
  try {
    impl_.connection.Execute("ROLLBACK", "undo the edits of the database");
  } catch (const Error&) {
    // SQLite has rolled back by itself (disk full, for example), or will at the next opening.
  }
}

void Database::Transaction::Commit() {
  impl_.connection.Execute("COMMIT", "save the edits of the database");
  is_open_ = false;
}

void Database::Transaction::InsertCamera(CameraId camera_id, const DatabaseCamera& camera) {
  RequireSound(impl_.connection, camera_id, camera);
  SqliteStatement statement(impl_.connection,
                            "INSERT INTO cameras(model, width, height, params, "
                            "prior_focal_length, camera_id) VALUES (?, ?, ?, ?, ?, ?)",
                            "insert " + NameOfCamera(camera_id));
  BindCamera(camera_id, camera, &statement);
  statement.Step();
  if (impl_.schema.has_frames) RigOf(impl_.connection, camera_id);
}

void Database::Transaction::UpdateCamera(CameraId camera_id, const DatabaseCamera& camera) {
  RequireSound(impl_.connection, camera_id, camera);
  SqliteStatement statement(impl_.connection,
                            "UPDATE cameras SET model = ?, width = ?, height = ?, params = ?, "
                            "prior_focal_length = ? WHERE camera_id = ? RETURNING camera_id",
                            "update " + NameOfCamera(camera_id));
  BindCamera(camera_id, camera, &statement);
  if (!statement.Step()) {
    impl_.connection.FailWith("has no " + NameOfCamera(camera_id) + " to update");
  }
  statement.Step();
}

void Database::Transaction::InsertImage(ImageId image_id, const DatabaseImage& image) {
  const SqliteConnection& connection = impl_.connection;
  if (image_id < 1 || image_id > kMaxImageId || image.name.empty()) {
    connection.FailWith("cannot insert " + NameOf(image_id) + " '" + image.name +
                        "': ids are 1 to " + std::to_string(kMaxImageId) + ", names are not empty");
  }
  if (image.prior) RequirePlaceForPrior(connection, impl_.schema, image_id, *image.prior);
  SqliteStatement(connection, "INSERT INTO images(image_id, name, camera_id) VALUES (?, ?, ?)",
                  "insert " + NameOf(image_id) + " '" + image.name + "' of camera " +
                      std::to_string(image.camera_id))
      .Bind(static_cast<std::int64_t>(image_id))
      .Bind(image.name)
      .Bind(static_cast<std::int64_t>(image.camera_id))
      .Step();
  if (impl_.schema.has_frames) InsertFrame(connection, image_id, image.camera_id);
  if (image.prior) WritePrior(connection, impl_.schema, image_id, *image.prior);
}

void Database::Transaction::SetPositionPrior(ImageId image_id, const Eigen::Vector3d& position,
                                             PriorFrame frame) {
  const PositionPrior prior{position, frame};
  RequirePlaceForPrior(impl_.connection, impl_.schema, image_id, prior);
  WritePrior(impl_.connection, impl_.schema, image_id, prior);
}

void Database::Transaction::InsertKeypoints(ImageId image_id, const KeypointMatrix& keypoints) {
  if (keypoints.rows() == 0) {  // COLMAP asks for the columns of nothing as well
    InsertMatrix(impl_.connection, "keypoints", image_id, KeypointMatrix(0, 6));
    return;
  }
  const Eigen::Index cols = keypoints.cols();
  if (cols != 2 && cols != 4 && cols != 6) {
    impl_.connection.FailWith("keypoints of " + NameOf(image_id) + " have " + std::to_string(cols) +
                              " columns, not 2, 4 or 6");
  }
  InsertMatrix(impl_.connection, "keypoints", image_id, keypoints);
}

void Database::Transaction::InsertDescriptors(ImageId image_id,
                                              const DescriptorMatrix& descriptors) {
  InsertMatrix(impl_.connection, "descriptors", image_id, descriptors,
               impl_.schema.has_descriptor_type ? "type" : "");
}

void Database::Transaction::InsertMatches(const ImagePair& pair,
                                          const std::vector<KeypointMatch>& matches) {
  std::vector<KeypointMatch> ordered = matches;
  if (IsSwapped(pair)) SwapMatches(&ordered);
  const std::vector<std::uint32_t> flat = Flatten(ordered);
  SqliteStatement(impl_.connection,
                  "INSERT INTO matches(pair_id, rows, cols, data) VALUES (?, ?, 2, ?)",
                  "insert the matches of " + NameOfPair(pair))
      .Bind(static_cast<std::int64_t>(PairIdOf(pair)))
      .Bind(static_cast<std::int64_t>(matches.size()))
      .BindBlob(flat.data(), flat.size() * sizeof(std::uint32_t))
      .Step();
}

void Database::Transaction::InsertTwoViewGeometry(const ImagePair& pair,
                                                  const TwoViewGeometry& geometry) {
  TwoViewGeometry ordered = geometry;
  if (IsSwapped(pair)) InvertGeometry(&ordered);
  const std::vector<std::uint32_t> flat = Flatten(ordered.inlier_matches);
  // Row by row, as COLMAP stores matrices.
  const Eigen::Matrix3d f = ordered.F.transpose();
  const Eigen::Matrix3d e = ordered.E.transpose();
  const Eigen::Matrix3d h = ordered.H.transpose();
  const PoseColumns pose(ordered.cam2_from_cam1, impl_.schema.unknown_geometry);
  SqliteStatement statement(impl_.connection,
                            "INSERT INTO two_view_geometries(pair_id, rows, cols, data, config, "
                            "F, E, H, qvec, tvec) VALUES (?, ?, 2, ?, ?, ?, ?, ?, ?, ?)",
                            "insert the two-view geometry of " + NameOfPair(pair));
  statement.Bind(static_cast<std::int64_t>(PairIdOf(pair)))
      .Bind(static_cast<std::int64_t>(geometry.inlier_matches.size()))
      .BindBlob(flat.data(), flat.size() * sizeof(std::uint32_t))
      .Bind(static_cast<std::int64_t>(geometry.config));
  const bool as_null = impl_.schema.unknown_geometry == UnknownGeometry::kNull;
  for (const Eigen::Matrix3d* matrix : {&f, &e, &h}) {
    if (as_null && matrix->isZero(0)) {
      statement.BindNull();
    } else {
      statement.BindBlob(matrix->data(), 9 * sizeof(double));
    }
  }
  pose.BindTo(&statement);
  statement.Step();
}

}  // namespace colmap_ext
