// What COLMAP's versions put into their databases: every difference between schemas is in this
// file's .cc and nowhere else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "scene/sqlite.h"

namespace colmap_ext {

// Where the position priors (GPS) of photos are.
enum class PriorLayout {
  kNone,
  kImageColumns,  // until 3.9: images.prior_tx, prior_ty, prior_tz
  kTableByImage,  // 3.10 and 3.11: pose_priors.image_id
  kTableByData,   // 4.x: pose_priors.corr_data_id, of the sensors that are cameras
};

// How a two-view geometry says that a matrix or the pose was not estimated.
enum class UnknownGeometry {
  kZero,      // 3.8: zeros
  kIdentity,  // 3.9 and later: a pose of identity; matrices of zeros
  kNull,      // 4.x
};

struct DatabaseSchema {
  int user_version = 0;
  PriorLayout prior_layout = PriorLayout::kNone;
  bool has_frames = false;           // 3.12 and later: photos also belong to rigs and frames
  bool has_descriptor_type = false;  // 4.x: which kind of feature
  UnknownGeometry unknown_geometry = UnknownGeometry::kZero;
  // Tables of priors with a covariance (3.11 and later) and a direction of gravity (4.x).
  bool has_prior_covariance = false, has_prior_gravity = false;
  // Expressions that give a column of two_view_geometries, or NULL in a schema that lacks it.
  std::string f_column, e_column, h_column, qvec_column, tvec_column;

  // A column that must be filled and that we know nothing of: "table.column".
  std::string unknown_column;

  // "" when our edits fit this schema, else why not.
  std::string WhyNotEditable() const;

  // SELECT image_id, name, camera_id, then the prior as this schema has it:
  // prior_x, prior_y, prior_z (kImageColumns), or blob and coordinate system (tables).
  std::string SelectImages() const;
};

// Throws Error naming the file when it is too short for what its header says, or no SQLite
// database. (SQLite itself takes a file cut inside its last page for sound.)
void CheckSqliteFile(const std::filesystem::path& path);

// Throws Error naming the first table or column of COLMAP's that is missing.
DatabaseSchema DetectSchema(const SqliteConnection& connection);

// The statements that make an empty database of COLMAP 3.8.
const char* CreateSchema38();

}  // namespace colmap_ext
