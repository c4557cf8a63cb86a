#include <cmath>

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

std::string NameOf(ImageId image_id) { return "image " + std::to_string(image_id); }

std::string NameOf(const ImagePair& pair) {
  return "images " + std::to_string(pair.first) + " and " + std::to_string(pair.second);
}

void BindPrior(const std::optional<PositionPrior>& prior, SqliteStatement* statement) {
  for (int axis = 0; axis < 3; ++axis) {
    if (prior) {
      statement->Bind(prior->position[axis]);
    } else {
      statement->BindNull();
    }
  }
}

void RequirePriorColumns(const SqliteConnection& connection, const DatabaseSchema& schema) {
  if (schema.prior_layout == PriorLayout::kImageColumns) return;
  connection.FailWith("its position priors (GPS) are not where COLMAP 3.8 has them (user_version " +
                      std::to_string(schema.user_version) +
                      "); let that COLMAP read them from the photos");
}

void RequireFinite(const SqliteConnection& connection, ImageId image_id,
                   const Eigen::Vector3d& position) {
  if (position.allFinite()) return;
  connection.FailWith(NameOf(image_id) + " has a position prior that is no finite number");
}

template <typename Matrix>
void InsertMatrix(const SqliteConnection& connection, const std::string& table, ImageId image_id,
                  const Matrix& matrix) {
  const std::size_t num_bytes =
      static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar);
  SqliteStatement(connection,
                  "INSERT INTO " + table + "(image_id, rows, cols, data) VALUES (?, ?, ?, ?)",
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
  const std::string name = "camera " + std::to_string(camera_id);
  const CameraModelInfo& info = GetCameraModelInfo(static_cast<int>(camera.camera.model));
  const std::vector<double>& params = camera.camera.params;
  if (camera_id == 0 || camera.camera.width <= 0 || camera.camera.height <= 0 ||
      params.size() != static_cast<std::size_t>(info.num_params)) {
    impl_.connection.FailWith("cannot insert " + name +
                              ": its id or size is not > 0, or it has not the " +
                              std::to_string(info.num_params) + " parameters of " + info.name);
  }
  SqliteStatement(impl_.connection,
                  "INSERT INTO cameras(camera_id, model, width, height, params, "
                  "prior_focal_length) VALUES (?, ?, ?, ?, ?, ?)",
                  "insert " + name)
      .Bind(static_cast<std::int64_t>(camera_id))
      .Bind(static_cast<std::int64_t>(camera.camera.model))
      .Bind(static_cast<std::int64_t>(camera.camera.width))
      .Bind(static_cast<std::int64_t>(camera.camera.height))
      .BindBlob(params.data(), params.size() * sizeof(double))
      .Bind(static_cast<std::int64_t>(camera.has_prior_focal_length ? 1 : 0))
      .Step();
}

void Database::Transaction::InsertImage(ImageId image_id, const DatabaseImage& image) {
  const SqliteConnection& connection = impl_.connection;
  if (image_id < 1 || image_id > kMaxImageId || image.name.empty()) {
    connection.FailWith("cannot insert " + NameOf(image_id) + " '" + image.name +
                        "': ids are 1 to " + std::to_string(kMaxImageId) + ", names are not empty");
  }
  const std::string doing = "insert " + NameOf(image_id) + " '" + image.name + "' of camera " +
                            std::to_string(image.camera_id);
  if (!image.prior) {
    SqliteStatement(connection, "INSERT INTO images(image_id, name, camera_id) VALUES (?, ?, ?)",
                    doing)
        .Bind(static_cast<std::int64_t>(image_id))
        .Bind(image.name)
        .Bind(static_cast<std::int64_t>(image.camera_id))
        .Step();
    return;
  }
  RequirePriorColumns(connection, impl_.schema);
  RequireFinite(connection, image_id, image.prior->position);
  SqliteStatement statement(connection,
                            "INSERT INTO images(image_id, name, camera_id, prior_tx, prior_ty, "
                            "prior_tz) VALUES (?, ?, ?, ?, ?, ?)",
                            doing);
  statement.Bind(static_cast<std::int64_t>(image_id))
      .Bind(image.name)
      .Bind(static_cast<std::int64_t>(image.camera_id));
  BindPrior(image.prior, &statement);
  statement.Step();
}

void Database::Transaction::SetPositionPrior(ImageId image_id, const Eigen::Vector3d& position) {
  const SqliteConnection& connection = impl_.connection;
  RequirePriorColumns(connection, impl_.schema);
  RequireFinite(connection, image_id, position);
  SqliteStatement statement(connection,
                            "UPDATE images SET prior_tx = ?, prior_ty = ?, prior_tz = ? "
                            "WHERE image_id = ? RETURNING image_id",
                            "set the position prior of " + NameOf(image_id));
  BindPrior(PositionPrior{position, PriorFrame::kUnknown}, &statement);
  statement.Bind(static_cast<std::int64_t>(image_id));
  if (!statement.Step()) {
    connection.FailWith("has no " + NameOf(image_id) + " to set a position prior of");
  }
  while (statement.Step()) {
  }
}

void Database::Transaction::InsertKeypoints(ImageId image_id, const KeypointMatrix& keypoints) {
  const Eigen::Index cols = keypoints.cols();
  if (cols != 2 && cols != 4 && cols != 6) {
    impl_.connection.FailWith("keypoints of " + NameOf(image_id) + " have " + std::to_string(cols) +
                              " columns, not 2, 4 or 6");
  }
  InsertMatrix(impl_.connection, "keypoints", image_id, keypoints);
}

void Database::Transaction::InsertDescriptors(ImageId image_id,
                                              const DescriptorMatrix& descriptors) {
  InsertMatrix(impl_.connection, "descriptors", image_id, descriptors);
}

void Database::Transaction::InsertMatches(const ImagePair& pair,
                                          const std::vector<KeypointMatch>& matches) {
  std::vector<KeypointMatch> ordered = matches;
  if (IsSwapped(pair)) SwapMatches(&ordered);
  const std::vector<std::uint32_t> flat = Flatten(ordered);
  SqliteStatement(impl_.connection,
                  "INSERT INTO matches(pair_id, rows, cols, data) VALUES (?, ?, 2, ?)",
                  "insert the matches of " + NameOf(pair))
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
  // Row by row, as COLMAP stores matrices; zeros for a pose that is not known.
  const Eigen::Matrix3d f = ordered.F.transpose();
  const Eigen::Matrix3d e = ordered.E.transpose();
  const Eigen::Matrix3d h = ordered.H.transpose();
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  if (ordered.cam2_from_cam1) {
    const Eigen::Quaterniond& rotation = ordered.cam2_from_cam1->rotation;
    q = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
    t = ordered.cam2_from_cam1->translation;
  }
  SqliteStatement(impl_.connection,
                  "INSERT INTO two_view_geometries(pair_id, rows, cols, data, config, F, E, H, "
                  "qvec, tvec) VALUES (?, ?, 2, ?, ?, ?, ?, ?, ?, ?)",
                  "insert the two-view geometry of " + NameOf(pair))
      .Bind(static_cast<std::int64_t>(PairIdOf(pair)))
      .Bind(static_cast<std::int64_t>(geometry.inlier_matches.size()))
      .BindBlob(flat.data(), flat.size() * sizeof(std::uint32_t))
      .Bind(static_cast<std::int64_t>(geometry.config))
      .BindBlob(f.data(), sizeof(f))
      .BindBlob(e.data(), sizeof(e))
      .BindBlob(h.data(), sizeof(h))
      .BindBlob(q.data(), sizeof(q))
      .BindBlob(t.data(), sizeof(t))
      .Step();
}

}  // namespace colmap_ext
