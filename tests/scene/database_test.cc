#include "colmap_ext/scene/database.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <Eigen/LU>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>

#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Access = Database::Access;

DatabaseCamera MakeCamera() {
  return {{CameraModel::kSimpleRadial, 640, 368, {500, 320, 184, 0.01}}, true};
}

DatabaseImage MakeImage(const std::string& name) {
  return {name, 7, PositionPrior{{47.5, 8.25, 431.125}, PriorFrame::kUnknown}};
}

KeypointMatrix MakeKeypoints(int rows, int cols) {
  KeypointMatrix keypoints(rows, cols);
  for (int i = 0; i < rows * cols; ++i) keypoints.data()[i] = 0.25f * static_cast<float>(i);
  return keypoints;
}

DescriptorMatrix MakeDescriptors(int rows) {
  DescriptorMatrix descriptors(rows, 128);
  for (int i = 0; i < rows * 128; ++i) descriptors.data()[i] = static_cast<std::uint8_t>(i * 7);
  return descriptors;
}

TwoViewGeometry MakeGeometry() {
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
Database MakeDatabase(const fs::path& path) {
  Database database = Database::Create(path);
  Database::Transaction edit(database);
  edit.InsertCamera(7, MakeCamera());
  edit.InsertImage(12, MakeImage("a.jpg"));
  edit.InsertImage(5, {"folder/b.jpg", 7, std::nullopt});
  edit.InsertKeypoints(12, MakeKeypoints(30, 6));
  edit.InsertKeypoints(5, MakeKeypoints(40, 4));
  edit.InsertDescriptors(12, MakeDescriptors(30));
  edit.InsertDescriptors(5, MakeDescriptors(40));
  edit.InsertMatches({5, 12}, {{0, 1}, {2, 3}, {39, 29}});
  edit.InsertTwoViewGeometry({5, 12}, MakeGeometry());
  edit.Commit();
  return database;
}

// Everything that a reader can be asked.
void ReadAll(const fs::path& path) {
  const Database database = Database::Open(path, Access::kReadOnly);
  database.ReadCameras();
  for (const auto& [id, image] : database.ReadImages()) {
    database.FindImage(image.name);
    database.ReadKeypoints(id);
    database.ReadDescriptors(id);
  }
  database.NumKeypoints();
  for (const auto& [pair, count] : database.NumMatches()) database.ReadMatches(pair);
  for (const auto& [pair, summary] : database.TwoViewSummaries()) {
    database.ReadTwoViewGeometry(pair);
  }
}

// Runs SQL as a foreign program would.
void RunSql(const fs::path& path, const std::string& sql) {
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &handle), SQLITE_OK);
  sqlite3_exec(handle, "PRAGMA synchronous = OFF", nullptr, nullptr, nullptr);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
  sqlite3_free(message);
  sqlite3_close(handle);
}

std::set<std::string> FilesIn(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

TEST(PairId, IsColmapsAndComesBack) {
  EXPECT_EQ(PairIdOf({1, 2}), 2147483647u + 2u);
  EXPECT_EQ(PairIdOf({2, 1}), PairIdOf({1, 2}));
  for (const ImagePair& pair : {ImagePair{1, 2}, {5, 12}, {1, kMaxImageId}, {77, 1000000}}) {
    EXPECT_EQ(PairOfId(PairIdOf(pair)), pair);
  }
}

TEST(PairId, ImpossibleOnesAreErrors) {
  EXPECT_THROW(PairIdOf({3, 3}), Error);
  EXPECT_THROW(PairIdOf({0, 3}), Error);
  EXPECT_THROW(PairIdOf({1, kMaxImageId + 1}), Error);
  EXPECT_THROW(PairOfId(0), Error);
  EXPECT_THROW(PairOfId(5), Error);                        // image 0
  EXPECT_THROW(PairOfId(2147483647ull * 5 + 5), Error);    // the same image twice
  EXPECT_THROW(PairOfId(2147483647ull * 5 + 3), Error);    // wrong order
  EXPECT_THROW(PairOfId(18446744073709551615ull), Error);  // -1 in SQL
}

TEST(Database, WhatIsWrittenComesBack) {
  TestFolder folder;
  MakeDatabase(folder / "new/database.db");
  const Database database = Database::Open(folder / "new/database.db", Access::kReadOnly);
  EXPECT_EQ(database.user_version(), 3800);
  const auto cameras = database.ReadCameras();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras.at(7).camera.model, CameraModel::kSimpleRadial);
  EXPECT_EQ(cameras.at(7).camera.params, MakeCamera().camera.params);
  EXPECT_EQ(cameras.at(7).camera.width, 640);
  EXPECT_EQ(cameras.at(7).camera.height, 368);
  EXPECT_TRUE(cameras.at(7).has_prior_focal_length);
  const auto images = database.ReadImages();
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images.at(12).name, "a.jpg");
  EXPECT_EQ(images.at(12).camera_id, 7u);
  ASSERT_TRUE(images.at(12).prior.has_value());
  EXPECT_EQ(images.at(12).prior->position, Eigen::Vector3d(47.5, 8.25, 431.125));
  EXPECT_FALSE(images.at(5).prior.has_value());
  EXPECT_EQ(database.FindImage("folder/b.jpg"), ImageId{5});
  EXPECT_EQ(database.FindImage("c.jpg"), std::nullopt);
}

TEST(Database, FeaturesComeBack) {
  TestFolder folder;
  const Database database = MakeDatabase(folder / "d.db");
  EXPECT_EQ(database.ReadKeypoints(12), MakeKeypoints(30, 6));
  EXPECT_EQ(database.ReadKeypoints(5), MakeKeypoints(40, 4));
  EXPECT_EQ(database.ReadDescriptors(5), MakeDescriptors(40));
  EXPECT_EQ(database.NumKeypoints(), (std::map<ImageId, std::size_t>{{5, 40}, {12, 30}}));
  EXPECT_EQ(database.ReadKeypoints(99).rows(), 0);
  EXPECT_EQ(database.ReadDescriptors(99).rows(), 0);
}

TEST(Database, MatchesAreGivenInTheOrderOfThePair) {
  TestFolder folder;
  const Database database = MakeDatabase(folder / "d.db");
  using Matches = std::vector<KeypointMatch>;
  EXPECT_EQ(database.ReadMatches({5, 12}), (Matches{{0, 1}, {2, 3}, {39, 29}}));
  EXPECT_EQ(database.ReadMatches({12, 5}), (Matches{{1, 0}, {3, 2}, {29, 39}}));
  EXPECT_TRUE(database.ReadMatches({5, 13}).empty());
  EXPECT_EQ(database.NumMatches(), (std::map<ImagePair, std::size_t>{{{5, 12}, 3}}));
}

TEST(Database, MatchesInsertedInTheOtherOrderAreTheSame) {
  TestFolder folder;
  Database database = Database::Create(folder / "d.db");
  TwoViewGeometry swapped;
  swapped.config = TwoViewConfig::kPlanar;
  swapped.inlier_matches = {{1, 0}};
  Database::Transaction edit(database);
  edit.InsertMatches({12, 5}, {{1, 0}, {29, 39}});
  edit.InsertTwoViewGeometry({12, 5}, swapped);
  edit.Commit();
  EXPECT_EQ(database.ReadMatches({5, 12}), (std::vector<KeypointMatch>{{0, 1}, {39, 29}}));
  EXPECT_EQ(database.ReadTwoViewGeometry({5, 12})->inlier_matches,
            (std::vector<KeypointMatch>{{0, 1}}));
}

TEST(Database, TwoViewGeometryComesBackInBothOrders) {
  TestFolder folder;
  const Database database = MakeDatabase(folder / "d.db");
  const TwoViewGeometry wanted = MakeGeometry();
  const auto geometry = database.ReadTwoViewGeometry({5, 12});
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->config, TwoViewConfig::kCalibrated);
  EXPECT_EQ(geometry->inlier_matches, wanted.inlier_matches);
  EXPECT_EQ(geometry->F, wanted.F);
  EXPECT_EQ(geometry->E, wanted.E);
  EXPECT_EQ(geometry->H, wanted.H);
  ASSERT_TRUE(geometry->cam2_from_cam1.has_value());
  EXPECT_EQ(geometry->cam2_from_cam1->translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_LT(geometry->cam2_from_cam1->rotation.angularDistance(wanted.cam2_from_cam1->rotation),
            1e-7);

  const auto inverse = database.ReadTwoViewGeometry({12, 5});
  EXPECT_EQ(inverse->inlier_matches, (std::vector<KeypointMatch>{{5, 0}, {3, 2}}));
  EXPECT_EQ(inverse->F, wanted.F.transpose());
  EXPECT_EQ(inverse->E, wanted.E.transpose());
  EXPECT_TRUE((inverse->H * wanted.H).isIdentity(1e-12));
  const Eigen::Vector3d point(0.3, -0.2, 5);
  EXPECT_LT((*inverse->cam2_from_cam1 * (*geometry->cam2_from_cam1 * point) - point).norm(), 1e-12);

  const auto summaries = database.TwoViewSummaries();
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries.at({5, 12}).config, TwoViewConfig::kCalibrated);
  EXPECT_EQ(summaries.at({5, 12}).num_inliers, 2u);
  EXPECT_FALSE(database.ReadTwoViewGeometry({5, 6}).has_value());
}

TEST(Database, PairsTriedInVainAreListedWithZero) {
  TestFolder folder;
  Database database = Database::Create(folder / "d.db");
  {
    Database::Transaction edit(database);
    edit.InsertMatches({1, 2}, {});
    edit.InsertTwoViewGeometry({1, 2}, {});
    edit.Commit();
  }
  EXPECT_EQ(database.NumMatches().at({1, 2}), 0u);
  EXPECT_TRUE(database.ReadMatches({1, 2}).empty());
  EXPECT_EQ(database.TwoViewSummaries().at({1, 2}).num_inliers, 0u);
  EXPECT_FALSE(database.ReadTwoViewGeometry({2, 1})->cam2_from_cam1.has_value());
}

TEST(DatabaseTransaction, WithoutCommitNothingStays) {
  TestFolder folder;
  Database database = MakeDatabase(folder / "d.db");
  {
    Database::Transaction edit(database);
    edit.InsertCamera(8, MakeCamera());
    edit.InsertImage(13, MakeImage("c.jpg"));
    edit.SetPositionPrior(5, {1, 2, 3});
  }
  EXPECT_EQ(database.ReadCameras().size(), 1u);
  EXPECT_EQ(database.ReadImages().size(), 2u);
  EXPECT_FALSE(database.ReadImages().at(5).prior.has_value());
  // And the next one is not disturbed.
  Database::Transaction edit(database);
  edit.SetPositionPrior(5, {1, 2, 3});
  edit.Commit();
  EXPECT_EQ(database.ReadImages().at(5).prior->position, Eigen::Vector3d(1, 2, 3));
}

TEST(DatabaseTransaction, WhatContradictsTheDatabaseIsAnErrorThatNamesIt) {
  TestFolder folder;
  Database database = MakeDatabase(folder / "d.db");
  Database::Transaction edit(database);
  EXPECT_ERROR_HAS(edit.InsertCamera(7, MakeCamera()), "insert camera 7");
  EXPECT_ERROR_HAS(edit.InsertCamera(0, MakeCamera()), "camera 0");
  DatabaseCamera short_camera = MakeCamera();
  short_camera.camera.params.pop_back();
  EXPECT_ERROR_HAS(edit.InsertCamera(9, short_camera), "4 parameters of SIMPLE_RADIAL");
  EXPECT_ERROR_HAS(edit.InsertImage(12, MakeImage("new.jpg")), "insert image 12 'new.jpg'");
  EXPECT_ERROR_HAS(edit.InsertImage(13, MakeImage("a.jpg")), "UNIQUE");
  EXPECT_ERROR_HAS(edit.InsertImage(13, MakeImage("")), "names are not empty");
  EXPECT_ERROR_HAS(edit.InsertImage(0, MakeImage("new.jpg")), "ids are 1 to 2147483646");
  EXPECT_ERROR_HAS(edit.InsertImage(kMaxImageId + 1, MakeImage("new.jpg")), "ids are 1");
  EXPECT_ERROR_HAS(edit.InsertImage(13, {"new.jpg", 99, {}}), "of camera 99");
  EXPECT_ERROR_HAS(edit.SetPositionPrior(99, {1, 2, 3}), "image 99");
  EXPECT_ERROR_HAS(edit.SetPositionPrior(5, {1, 2, std::nan("")}), "no finite number");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(12, MakeKeypoints(3, 6)), "keypoints of image 12");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(99, MakeKeypoints(3, 6)), "keypoints of image 99");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(5, MakeKeypoints(3, 5)), "5 columns");
  EXPECT_ERROR_HAS(edit.InsertMatches({12, 5}, {}), "matches of images 12 and 5");
  EXPECT_ERROR_HAS(edit.InsertMatches({5, 5}, {}), "no pair");
  EXPECT_NO_THROW(edit.InsertImage(13, MakeImage("new.jpg")));
  edit.Commit();
  EXPECT_EQ(database.ReadImages().size(), 3u);
}

TEST(DatabaseTransaction, ReadOnlyAndLockedDatabasesAreErrors) {
  TestFolder folder;
  Database database = MakeDatabase(folder / "d.db");
  Database reader = Database::Open(folder / "d.db", Access::kReadOnly);
  EXPECT_ERROR_HAS(Database::Transaction edit(reader), "d.db: cannot be edited");
  Database other = Database::Open(folder / "d.db", Access::kReadWrite);
  Database::Transaction edit(database);
  EXPECT_ERROR_HAS(Database::Transaction second(other), "another program uses the database");
}

TEST(Database, ReadingLeavesNoTraceBesideADatabaseInWalMode) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  RunSql(folder / "d.db", "PRAGMA journal_mode = WAL");
  const std::string before = ReadFile(folder / "d.db");
  ReadAll(folder / "d.db");
  EXPECT_EQ(FilesIn(folder.path()), std::set<std::string>{"d.db"});
  EXPECT_EQ(ReadFile(folder / "d.db"), before);
}

TEST(Database, NamesWithSpecialCharactersAreOpened) {
  TestFolder folder;
  for (const char* name : {"a b.db", "100%?x=1#y&z.db", "Größe.db"}) {
    MakeDatabase(folder / name);
    EXPECT_NO_THROW(ReadAll(folder / name)) << name;
    EXPECT_TRUE(FilesIn(folder.path()).contains(name));
  }
}

TEST(Database, CopyHasWhatIsStillInTheWriteAheadLog) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  sqlite3* writer = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "d.db").c_str(), &writer), SQLITE_OK);
  const char* sql =
      "PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0;"
      "INSERT INTO images(image_id, name, camera_id) VALUES(99, 'late.jpg', 7)";
  ASSERT_EQ(sqlite3_exec(writer, sql, nullptr, nullptr, nullptr), SQLITE_OK);
  ASSERT_GT(fs::file_size(folder / "d.db-wal"), 0u);
  Database::Copy(folder / "d.db", folder / "new/copy.db");
  sqlite3_close(writer);
  const Database copy = Database::Open(folder / "new/copy.db", Access::kReadOnly);
  EXPECT_EQ(copy.FindImage("late.jpg"), ImageId{99});
  EXPECT_EQ(copy.ReadDescriptors(5), MakeDescriptors(40));
  EXPECT_EQ(copy.user_version(), 3800);
  EXPECT_EQ(FilesIn(folder / "new"), std::set<std::string>{"copy.db"});
  EXPECT_ERROR_HAS(Database::Copy(folder / "d.db", folder / "new/copy.db"), "exists already");
}

TEST(Database, CreateDoesNotOverwrite) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  EXPECT_ERROR_HAS(Database::Create(folder / "d.db"), "exists already");
  EXPECT_NO_THROW(ReadAll(folder / "d.db"));
  EXPECT_ERROR_HAS(Database::Create("/proc/nothing/d.db"), "/proc/nothing");
}

// ---- Bad files.

TEST(DatabaseFile, MissingEmptyAndForeignFilesAreErrors) {
  TestFolder folder;
  EXPECT_ERROR_HAS(ReadAll(folder / "none.db"), "none.db");
  EXPECT_ERROR_HAS(ReadAll(folder.path()), "folder");
  std::ofstream(folder / "empty.db").flush();
  EXPECT_ERROR_HAS(ReadAll(folder / "empty.db"), "no SQLite database");
  std::ofstream(folder / "text.db") << std::string(10000, 'x');
  EXPECT_ERROR_HAS(ReadAll(folder / "text.db"), "no SQLite database");
  RunSql(folder / "foreign.db", "CREATE TABLE cameras(camera_id INTEGER); CREATE TABLE x(y)");
  EXPECT_ERROR_HAS(ReadAll(folder / "foreign.db"), "table 'cameras' has no column 'model'");
  RunSql(folder / "other.db", "CREATE TABLE x(y)");
  EXPECT_ERROR_HAS(ReadAll(folder / "other.db"), "is no COLMAP database");
}

TEST(DatabaseFile, EveryMissingTableIsNamed) {
  TestFolder folder;
  for (const char* table : {"keypoints", "descriptors", "matches", "two_view_geometries"}) {
    const fs::path path = folder / (std::string(table) + ".db");
    MakeDatabase(path);
    RunSql(path, std::string("DROP TABLE ") + table);
    EXPECT_ERROR_HAS(ReadAll(path), std::string("no table '") + table + "'");
  }
}

TEST(DatabaseFile, TruncatedAnywhereIsAnError) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  const std::size_t full = fs::file_size(folder / "d.db");
  ASSERT_GT(full, 40000u);
  for (std::size_t size = full - 1; size > 61; size -= 61) {
    fs::resize_file(folder / "d.db", size);
    EXPECT_ERROR_HAS(ReadAll(folder / "d.db"), "d.db");
  }
}

TEST(DatabaseFile, TruncatedAtAnyPageIsAnError) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  RunSql(folder / "d.db", "PRAGMA journal_mode = WAL");  // as COLMAP leaves it
  for (std::size_t size = fs::file_size(folder / "d.db") - 4096; size > 0; size -= 4096) {
    fs::resize_file(folder / "d.db", size);
    EXPECT_ERROR_HAS(ReadAll(folder / "d.db"), "d.db");
  }
}

TEST(DatabaseFile, DamagedBytesNeverCrash) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  const std::string content = ReadFile(folder / "d.db");
  std::fstream file(folder / "d.db", std::ios::binary | std::ios::in | std::ios::out);
  std::mt19937_64 random(5);
  int num_errors = 0;
  for (int i = 0; i < 1500; ++i) {
    const auto offset = static_cast<std::streamoff>(random() % content.size());
    file.seekp(offset).put(static_cast<char>(random())).flush();
    try {
      ReadAll(folder / "d.db");
    } catch (const Error& error) {
      EXPECT_HAS(error.what(), "d.db");
      ++num_errors;
    }
    file.seekp(offset).put(content[static_cast<std::size_t>(offset)]).flush();
  }
  EXPECT_GT(num_errors, 10);
  EXPECT_NO_THROW(ReadAll(folder / "d.db"));
}

struct BadRow {
  const char* name;
  const char* sql;
  const char* message;
};

const BadRow kBadRows[] = {
    {"UnknownCameraModel", "UPDATE cameras SET model = 13", "camera 7: unknown camera model id 13"},
    {"CameraParams", "UPDATE cameras SET params = x'0011'", "camera 7 has 0 parameters, not the 4"},
    {"CameraWidth", "UPDATE cameras SET width = -5", "column width holds -5"},
    {"CameraText", "UPDATE cameras SET height = 'tall'", "column height holds no whole number"},
    {"KeypointRows", "UPDATE keypoints SET rows = 31 WHERE image_id = 12",
     "keypoints of image 12 are 31 x 6, 744 bytes, but 720 are stored"},
    {"KeypointHugeRows", "UPDATE keypoints SET rows = 2147483647", "are 2147483647 x"},
    {"KeypointNegative", "UPDATE keypoints SET rows = -1, cols = -1", "column rows holds -1"},
    {"KeypointCols", "UPDATE keypoints SET rows = 36, cols = 5 WHERE image_id = 12",
     "have 5 columns"},
    {"KeypointNull", "UPDATE keypoints SET data = NULL", "but 0 are stored"},
    {"Descriptors", "UPDATE descriptors SET cols = 64 WHERE image_id = 5",
     "descriptors of image 5 are 40 x 64"},
    {"Matches", "UPDATE matches SET rows = 4", "matches of images 5 and 12 are 4 x 2"},
    {"MatchCols", "UPDATE matches SET rows = 2, cols = 3", "have 3 columns, not 2"},
    {"PairId", "UPDATE matches SET pair_id = 3", "pair id 3 is no pair of images"},
    {"Config", "UPDATE two_view_geometries SET config = 99", "column config holds 99"},
    {"Fundamental", "UPDATE two_view_geometries SET F = x'00'", "a geometry of 1 bytes"},
    {"PriorText", "UPDATE images SET prior_tx = 'north' WHERE image_id = 12",
     "column prior_tx holds no number"},
};

class DatabaseWithBadRow : public testing::TestWithParam<BadRow> {};
INSTANTIATE_TEST_SUITE_P(DatabaseFile, DatabaseWithBadRow, testing::ValuesIn(kBadRows),
                         [](const auto& info) { return info.param.name; });

TEST_P(DatabaseWithBadRow, IsAnErrorThatNamesFileAndRow) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  RunSql(folder / "d.db", GetParam().sql);
  const std::string message = ErrorOf([&] { ReadAll(folder / "d.db"); });
  EXPECT_HAS(message, (folder / "d.db").string());
  EXPECT_HAS(message, GetParam().message);
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

// ---- Newer and older schemas.

constexpr char kPosition[] = "x'0000000000804740000000000000204000000000000008C0'";  // 47, 8, -3

TEST(DatabaseSchema, PriorsOfColmap310AreRead) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  RunSql(folder / "d.db",
         "CREATE TABLE pose_priors(image_id INTEGER PRIMARY KEY NOT NULL, position BLOB, "
         "coordinate_system INTEGER NOT NULL); PRAGMA user_version = 3900;"
         "INSERT INTO pose_priors VALUES(5, " +
             std::string(kPosition) + ", 0)");
  Database database = Database::Open(folder / "d.db", Access::kReadWrite);
  EXPECT_EQ(database.user_version(), 3900);
  const auto images = database.ReadImages();
  ASSERT_TRUE(images.at(5).prior.has_value());
  EXPECT_EQ(images.at(5).prior->position, Eigen::Vector3d(47, 8, -3));
  EXPECT_EQ(images.at(5).prior->frame, PriorFrame::kWgs84);
  EXPECT_FALSE(images.at(12).prior.has_value());
  Database::Transaction edit(database);
  EXPECT_ERROR_HAS(edit.SetPositionPrior(5, {1, 2, 3}), "user_version 3900");
}

TEST(DatabaseSchema, PriorsOfColmap4AreReadAndItsDatabaseIsNotEdited) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  const std::string position = kPosition;
  RunSql(
      folder / "d.db",
      "CREATE TABLE pose_priors(pose_prior_id INTEGER PRIMARY KEY NOT NULL, corr_data_id INTEGER "
      "NOT NULL, corr_sensor_id INTEGER NOT NULL, corr_sensor_type INTEGER NOT NULL, position "
      "BLOB, position_covariance BLOB, gravity BLOB, coordinate_system INTEGER NOT NULL);"
      "CREATE TABLE frames(frame_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, rig_id INTEGER);"
      "ALTER TABLE images DROP COLUMN prior_tx; ALTER TABLE images DROP COLUMN prior_ty;"
      "ALTER TABLE images DROP COLUMN prior_tz; ALTER TABLE descriptors ADD COLUMN type INTEGER;"
      "PRAGMA user_version = 4020100;"
      "INSERT INTO pose_priors VALUES(1, 12, 7, 0, " +
          position +
          ", NULL, NULL, 1);"
          "INSERT INTO pose_priors VALUES(2, 5, 7, 1, " +
          position + ", NULL, NULL, 1)");
  Database database = Database::Open(folder / "d.db", Access::kReadWrite);
  const auto images = database.ReadImages();
  ASSERT_TRUE(images.at(12).prior.has_value());
  EXPECT_EQ(images.at(12).prior->position, Eigen::Vector3d(47, 8, -3));
  EXPECT_EQ(images.at(12).prior->frame, PriorFrame::kCartesian);
  EXPECT_FALSE(images.at(5).prior.has_value());  // of an inertial sensor with the same number
  EXPECT_EQ(database.ReadDescriptors(12), MakeDescriptors(30));
  EXPECT_ERROR_HAS(Database::Transaction edit(database), "user_version 4020100");
}

TEST(DatabaseSchema, GeometryThatASchemaLacksIsUnknown) {
  TestFolder folder;
  MakeDatabase(folder / "d.db");
  RunSql(folder / "d.db",
         "ALTER TABLE two_view_geometries DROP COLUMN qvec;"
         "ALTER TABLE two_view_geometries DROP COLUMN tvec; PRAGMA user_version = 3500");
  Database database = Database::Open(folder / "d.db", Access::kReadWrite);
  const auto geometry = database.ReadTwoViewGeometry({5, 12});
  EXPECT_EQ(geometry->F, MakeGeometry().F);
  EXPECT_FALSE(geometry->cam2_from_cam1.has_value());
  EXPECT_ERROR_HAS(Database::Transaction edit(database), "older than COLMAP 3.8");
}

}  // namespace
}  // namespace colmap_ext
