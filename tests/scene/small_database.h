// A small database with known content, for the tests of this module.
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <optional>
#include <string>

#include "colmap_ext/scene/database.h"

namespace colmap_ext {

inline DatabaseCamera MakeDatabaseCamera() {
  return {{CameraModel::kSimpleRadial, 640, 368, {500, 320, 184, 0.01}}, true};
}

inline DatabaseImage MakeDatabaseImage(const std::string& name) {
  return {name, 7, PositionPrior{{47.5, 8.25, 431.125}, PriorFrame::kUnknown}};
}

inline KeypointMatrix MakeKeypoints(int rows, int cols) {
  KeypointMatrix keypoints(rows, cols);
  for (int i = 0; i < rows * cols; ++i) keypoints.data()[i] = 0.25f * static_cast<float>(i);
  return keypoints;
}

inline DescriptorMatrix MakeDescriptors(int rows) {
  DescriptorMatrix descriptors(rows, 128);
  for (int i = 0; i < rows * 128; ++i) descriptors.data()[i] = static_cast<std::uint8_t>(i * 7);
  return descriptors;
}

inline TwoViewGeometry MakeGeometry() {
  TwoViewGeometry geometry;
  geometry.config = TwoViewConfig::kCalibrated;
  geometry.inlier_matches = {{0, 5}, {2, 3}};
  geometry.F << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  geometry.E << 0, -3, 2, 3, 0, -1, -2, 1, 0;
  geometry.H << 2, 0, 0, 0, 4, 0, 1, 0, 8;
  geometry.cam2_from_cam1 = Rigid3d{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3}};
  return geometry;
}

// Camera 7, photos 12 and 5, everything that belongs to them.
inline void FillDatabase(Database* database) {
  Database::Transaction edit(*database);
  edit.InsertCamera(7, MakeDatabaseCamera());
  edit.InsertImage(12, MakeDatabaseImage("a.jpg"));
  edit.InsertImage(5, {"folder/b.jpg", 7, std::nullopt});
  edit.InsertKeypoints(12, MakeKeypoints(30, 6));
  edit.InsertKeypoints(5, MakeKeypoints(40, 4));
  edit.InsertDescriptors(12, MakeDescriptors(30));
  edit.InsertDescriptors(5, MakeDescriptors(40));
  edit.InsertMatches({5, 12}, {{0, 1}, {2, 3}, {39, 29}});
  edit.InsertTwoViewGeometry({5, 12}, MakeGeometry());
  edit.Commit();
}

inline Database MakeDatabase(const std::filesystem::path& path) {
  Database database = Database::Create(path);
  FillDatabase(&database);
  return database;
}

// Everything that a reader can be asked.
inline void ReadAll(const std::filesystem::path& path) {
  const Database database = Database::Open(path, Database::Access::kReadOnly);
  database.ReadCameras();
  for (const auto& [id, image] : database.ReadImages()) {
    database.FindImage(image.name);
    database.ReadKeypoints(id);
    database.ReadDescriptors(id);
  }
  database.NumKeypoints();
  database.ReadFrameTable();
  for (const auto& [pair, count] : database.NumMatches()) database.ReadMatches(pair);
  for (const auto& [pair, summary] : database.TwoViewSummaries()) {
    database.ReadTwoViewGeometry(pair);
  }
}

// Runs SQL as a foreign program would.
inline void RunSql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &handle), SQLITE_OK);
  sqlite3_exec(handle, "PRAGMA synchronous = OFF", nullptr, nullptr, nullptr);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
  sqlite3_free(message);
  sqlite3_close(handle);
}

}  // namespace colmap_ext
