#include "scene/database_schema.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// What every version has and we need.
struct RequiredTable {
  const char* name;
  std::vector<const char*> columns;
};

const std::vector<RequiredTable>& RequiredTables() {
  static const std::vector<RequiredTable> tables = {
      {"cameras", {"camera_id", "model", "width", "height", "params", "prior_focal_length"}},
      {"images", {"image_id", "name", "camera_id"}},
      {"keypoints", {"image_id", "rows", "cols", "data"}},
      {"descriptors", {"image_id", "rows", "cols", "data"}},
      {"matches", {"pair_id", "rows", "cols", "data"}},
      {"two_view_geometries", {"pair_id", "rows", "cols", "data", "config"}},
  };
  return tables;
}

// What a database with frames has besides.
const std::vector<RequiredTable>& FrameTables() {
  static const std::vector<RequiredTable> tables = {
      {"rigs", {"rig_id", "ref_sensor_id", "ref_sensor_type"}},
      {"rig_sensors", {"rig_id", "sensor_id", "sensor_type", "sensor_from_rig"}},
      {"frames", {"frame_id", "rig_id"}},
      {"frame_data", {"frame_id", "data_id", "sensor_id", "sensor_type"}},
  };
  return tables;
}

// Columns that some versions have and that we fill or may leave empty.
const std::set<std::string>& OptionalColumns() {
  static const std::set<std::string> columns = {
      "descriptors.type",         "pose_priors.image_id",         "pose_priors.pose_prior_id",
      "pose_priors.corr_data_id", "pose_priors.corr_sensor_id",   "pose_priors.corr_sensor_type",
      "pose_priors.position",     "pose_priors.coordinate_system"};
  return columns;
}

// Empty when there is no such table.
std::set<std::string> ColumnsOf(const SqliteConnection& connection, const std::string& table) {
  SqliteStatement statement(connection, "SELECT name FROM pragma_table_info(?)",
                            "read the database's tables");
  statement.Bind(table);
  std::set<std::string> columns;
  while (statement.Step()) columns.insert(statement.Text(0));
  return columns;
}

// The first column of `table` that an insertion must fill, and that is none of `known`.
std::string UnknownColumn(const SqliteConnection& connection, const std::string& table,
                          const std::vector<const char*>& known) {
  SqliteStatement statement(connection,
                            "SELECT name FROM pragma_table_info(?) WHERE \"notnull\" AND "
                            "dflt_value IS NULL",
                            "read the database's tables");
  statement.Bind(table);
  while (statement.Step()) {
    const std::string name = statement.Text(0);
    const bool is_known = std::find(known.begin(), known.end(), name) != known.end() ||
                          OptionalColumns().contains(table + "." + name);
    if (!is_known) return table + "." + name;
  }
  return "";
}

void RequireColumns(const SqliteConnection& connection, const RequiredTable& table) {
  const std::set<std::string> columns = ColumnsOf(connection, table.name);
  if (columns.empty()) {
    connection.FailWith(std::string("is no COLMAP database (it has no table '") + table.name +
                        "'); give the database that `colmap feature_extractor` wrote");
  }
  for (const char* column : table.columns) {
    if (columns.contains(column)) continue;
    connection.FailWith(std::string("its table '") + table.name + "' has no column '" + column +
                        "'; it is of a version of COLMAP that is not supported, or damaged");
  }
}

PriorLayout DetectPriorLayout(const SqliteConnection& connection) {
  const std::set<std::string> priors = ColumnsOf(connection, "pose_priors");
  if (priors.contains("position") && priors.contains("coordinate_system")) {
    if (priors.contains("corr_data_id") && priors.contains("corr_sensor_type")) {
      return PriorLayout::kTableByData;
    }
    if (priors.contains("image_id")) return PriorLayout::kTableByImage;
  }
  if (ColumnsOf(connection, "images").contains("prior_tx")) return PriorLayout::kImageColumns;
  return PriorLayout::kNone;
}

std::string ColumnOrNull(const std::set<std::string>& columns, const std::string& name) {
  return columns.contains(name) ? name : "NULL";
}

}  // namespace

std::string DatabaseSchema::WhyNotEditable() const {
  const std::string version = " (user_version " + std::to_string(user_version) + ")";
  if (!unknown_column.empty()) {
    return "is of a version of COLMAP that is not known here" + version + ": its column '" +
           unknown_column + "' must be filled; add to it with that COLMAP's own commands";
  }
  for (const std::string* column : {&f_column, &e_column, &h_column, &qvec_column, &tvec_column}) {
    if (*column == "NULL") {
      return "is older than COLMAP 3.8" + version +
             "; open it once with COLMAP 3.8 (`colmap database_creator`), which migrates it";
    }
  }
  return "";
}

std::string DatabaseSchema::SelectImages() const {
  switch (prior_layout) {
    case PriorLayout::kNone:
      return "SELECT image_id, name, camera_id FROM images";
    case PriorLayout::kImageColumns:
      return "SELECT image_id, name, camera_id, prior_tx, prior_ty, prior_tz FROM images";
    case PriorLayout::kTableByImage:
      return "SELECT images.image_id, name, camera_id, position, coordinate_system FROM images "
             "LEFT JOIN pose_priors ON pose_priors.image_id = images.image_id";
    case PriorLayout::kTableByData:
      // Sensor type 0 is a camera, 1 an inertial sensor.
      return "SELECT images.image_id, name, camera_id, position, coordinate_system FROM images "
             "LEFT JOIN pose_priors ON corr_data_id = images.image_id AND corr_sensor_type = 0";
  }
  throw Error("unknown layout of priors");
}

void CheckSqliteFile(const std::filesystem::path& path) {
  RequireFile(path, "COLMAP database");
  std::ifstream file(path, std::ios::binary);
  char header[100] = {};
  file.read(header, sizeof(header));
  const bool is_sqlite = std::memcmp(header, "SQLite format 3", 16) == 0;
  if (!is_sqlite) {
    throw Error(path.string() +
                ": is no SQLite database, or an empty or corrupt one; give the database that "
                "`colmap feature_extractor` wrote");
  }
  // Bytes 16 and 17, big-endian: page size, where 1 means 65536.
  const auto high = static_cast<unsigned char>(header[16]);
  const auto low = static_cast<unsigned char>(header[17]);
  const std::uintmax_t stored = static_cast<std::uintmax_t>(high) * 256 + low;
  const std::uintmax_t page_size = stored == 1 ? 65536 : stored;
  const std::uintmax_t file_size = std::filesystem::file_size(path);
  // After a crash, the journal completes what is half written.
  if (HasPendingJournal(path)) return;
  if (page_size < 512 || file_size < page_size || file_size % page_size != 0) {
    throw Error(path.string() + ": " + std::to_string(file_size) +
                " bytes are not a whole number of database pages; it is truncated: restore a copy, "
                "or remove it and extract features again");
  }
}

DatabaseSchema DetectSchema(const SqliteConnection& connection) {
  DatabaseSchema schema;
  schema.has_frames = !ColumnsOf(connection, "frames").empty();
  std::vector<RequiredTable> tables = RequiredTables();
  if (schema.has_frames) tables.insert(tables.end(), FrameTables().begin(), FrameTables().end());
  for (const RequiredTable& table : tables) {
    RequireColumns(connection, table);
    if (schema.unknown_column.empty()) {
      schema.unknown_column = UnknownColumn(connection, table.name, table.columns);
    }
  }
  if (schema.unknown_column.empty()) {
    schema.unknown_column = UnknownColumn(connection, "pose_priors", {});
  }
  SqliteStatement version(connection, "PRAGMA user_version", "read the database's version");
  if (version.Step()) {
    schema.user_version = static_cast<int>(version.Integer(
        0, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()));
  }
  schema.prior_layout = DetectPriorLayout(connection);
  const std::set<std::string> priors = ColumnsOf(connection, "pose_priors");
  schema.has_prior_covariance = priors.contains("position_covariance");
  schema.has_prior_gravity = priors.contains("gravity");
  schema.has_descriptor_type = ColumnsOf(connection, "descriptors").contains("type");
  const std::set<std::string> geometry = ColumnsOf(connection, "two_view_geometries");
  if (schema.prior_layout != PriorLayout::kImageColumns) {
    schema.unknown_geometry =
        geometry.contains("camera1") ? UnknownGeometry::kNull : UnknownGeometry::kIdentity;
  }
  schema.f_column = ColumnOrNull(geometry, "F");
  schema.e_column = ColumnOrNull(geometry, "E");
  schema.h_column = ColumnOrNull(geometry, "H");
  schema.qvec_column = ColumnOrNull(geometry, "qvec");
  schema.tvec_column = ColumnOrNull(geometry, "tvec");
  return schema;
}

const char* CreateSchema38() {
  return "BEGIN;"
         "CREATE TABLE cameras ("
         " camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
         " model INTEGER NOT NULL, width INTEGER NOT NULL, height INTEGER NOT NULL,"
         " params BLOB, prior_focal_length INTEGER NOT NULL);"
         "CREATE TABLE images ("
         " image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
         " name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL,"
         " prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL,"
         " prior_tx REAL, prior_ty REAL, prior_tz REAL,"
         " CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),"
         " FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));"
         "CREATE UNIQUE INDEX index_name ON images(name);"
         "CREATE TABLE keypoints ("
         " image_id INTEGER PRIMARY KEY NOT NULL,"
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,"
         " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);"
         "CREATE TABLE descriptors ("
         " image_id INTEGER PRIMARY KEY NOT NULL,"
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,"
         " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);"
         "CREATE TABLE matches ("
         " pair_id INTEGER PRIMARY KEY NOT NULL,"
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB);"
         "CREATE TABLE two_view_geometries ("
         " pair_id INTEGER PRIMARY KEY NOT NULL,"
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,"
         " config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);"
         "PRAGMA user_version = 3800;"
         "COMMIT;";
}

}  // namespace colmap_ext
