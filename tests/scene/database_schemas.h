// The schemas of COLMAP's versions as facts: what `colmap database_creator` of each makes. 3.8's is
// the one that Database::Create makes.
#pragma once

#include <filesystem>
#include <string>

#include "scene/small_database.h"

namespace colmap_ext {

struct SchemaOfVersion {
  const char* name;
  int user_version;
  bool has_frames;
  bool prior_has_frame;  // the schema says what the numbers of a prior mean
  const char* priors;    // the table of priors
  const char* extra_descriptor_column;
  const char* extra_geometry_columns;
};

inline constexpr char kPriorsByImage[] =
    "CREATE TABLE pose_priors(image_id INTEGER PRIMARY KEY NOT NULL, position BLOB,"
    " coordinate_system INTEGER NOT NULL,"
    " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);";
inline constexpr char kPriorsWithCovariance[] =
    "CREATE TABLE pose_priors(image_id INTEGER PRIMARY KEY NOT NULL, position BLOB,"
    " coordinate_system INTEGER NOT NULL, position_covariance BLOB,"
    " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);";
inline constexpr char kPriorsByData[] =
    "CREATE TABLE pose_priors(pose_prior_id INTEGER PRIMARY KEY NOT NULL,"
    " corr_data_id INTEGER NOT NULL, corr_sensor_id INTEGER NOT NULL,"
    " corr_sensor_type INTEGER NOT NULL, position BLOB, position_covariance BLOB, gravity BLOB,"
    " coordinate_system INTEGER NOT NULL);"
    "CREATE UNIQUE INDEX pose_prior_data_assignment ON"
    " pose_priors(corr_data_id, corr_sensor_id, corr_sensor_type);";
inline constexpr char kRigsAndFrames[] =
    "CREATE TABLE rigs(rig_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
    " ref_sensor_id INTEGER NOT NULL, ref_sensor_type INTEGER NOT NULL);"
    "CREATE UNIQUE INDEX rig_ref_sensor_assignment ON rigs(ref_sensor_id, ref_sensor_type);"
    "CREATE TABLE rig_sensors(rig_id INTEGER NOT NULL, sensor_id INTEGER NOT NULL,"
    " sensor_type INTEGER NOT NULL, sensor_from_rig BLOB,"
    " FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);"
    "CREATE UNIQUE INDEX rig_sensor_assignment ON rig_sensors(sensor_id, sensor_type);"
    "CREATE TABLE frames(frame_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
    " rig_id INTEGER NOT NULL, FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);"
    "CREATE TABLE frame_data(frame_id INTEGER NOT NULL, data_id INTEGER NOT NULL,"
    " sensor_id INTEGER NOT NULL, sensor_type INTEGER NOT NULL,"
    " FOREIGN KEY(frame_id) REFERENCES frames(frame_id) ON DELETE CASCADE);"
    "CREATE UNIQUE INDEX frame_sensor_assignment ON frame_data(data_id, sensor_type);";

inline constexpr SchemaOfVersion kSchema38 = {"Colmap38", 3800, false, false, nullptr, "", ""};
inline constexpr SchemaOfVersion kSchema310 = {"Colmap310",    3900, false, true,
                                               kPriorsByImage, "",   ""};
inline constexpr SchemaOfVersion kSchema312 = {"Colmap312",           3900, true, true,
                                               kPriorsWithCovariance, "",   ""};
inline constexpr SchemaOfVersion kSchema42 = {"Colmap42",
                                              4020100,
                                              true,
                                              true,
                                              kPriorsByData,
                                              " type INTEGER NOT NULL,",
                                              ", camera1 BLOB, camera2 BLOB"};

// The statements that make an empty database of a version after 3.8.
inline std::string StatementsOf(const SchemaOfVersion& schema) {
  return std::string(schema.has_frames ? kRigsAndFrames : "") +
         "CREATE TABLE cameras(camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
         " model INTEGER NOT NULL, width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB,"
         " prior_focal_length INTEGER NOT NULL);"
         "CREATE TABLE images(image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
         " name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL,"
         " CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),"
         " FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));"
         "CREATE UNIQUE INDEX index_name ON images(name);" +
         schema.priors +
         "CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,"
         " cols INTEGER NOT NULL, data BLOB,"
         " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);"
         "CREATE TABLE descriptors(image_id INTEGER PRIMARY KEY NOT NULL," +
         schema.extra_descriptor_column +
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,"
         " FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);"
         "CREATE TABLE matches(pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,"
         " cols INTEGER NOT NULL, data BLOB);"
         "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY NOT NULL,"
         " rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB, config INTEGER NOT NULL,"
         " F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB" +
         schema.extra_geometry_columns +
         "); PRAGMA user_version = " + std::to_string(schema.user_version) + ";";
}

inline void CreateEmpty(const std::filesystem::path& path, const SchemaOfVersion& schema) {
  if (schema.priors == nullptr) {
    Database::Create(path);
  } else {
    RunSql(path, StatementsOf(schema));
  }
}

// The content of MakeDatabase in the schema of another version.
inline Database MakeDatabaseOf(const std::filesystem::path& path, const SchemaOfVersion& schema) {
  CreateEmpty(path, schema);
  Database database = Database::Open(path, Database::Access::kReadWrite);
  FillDatabase(&database);
  return database;
}

}  // namespace colmap_ext
