#include "colmap_ext/scene/database.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <Eigen/LU>
#include <filesystem>
#include <set>

#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/small_database.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Access = Database::Access;

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
  EXPECT_EQ(cameras.at(7).camera.params, MakeDatabaseCamera().camera.params);
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

// COLMAP stops at keypoints that have no columns, whatever photo shows nothing.
TEST(Database, PhotosWithoutFeaturesKeepTheColumns) {
  TestFolder folder;
  Database database = Database::Create(folder / "d.db");
  Database::Transaction edit(database);
  edit.InsertCamera(1, MakeDatabaseCamera());
  edit.InsertImage(1, {"black.jpg", 1, std::nullopt});
  edit.InsertKeypoints(1, KeypointMatrix());
  edit.Commit();
  EXPECT_EQ(database.ReadKeypoints(1).rows(), 0);
  EXPECT_EQ(database.ReadKeypoints(1).cols(), 6);
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
    edit.InsertCamera(8, MakeDatabaseCamera());
    edit.InsertImage(13, MakeDatabaseImage("c.jpg"));
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
  EXPECT_ERROR_HAS(edit.InsertCamera(7, MakeDatabaseCamera()), "insert camera 7");
  EXPECT_ERROR_HAS(edit.InsertCamera(0, MakeDatabaseCamera()), "camera 0");
  DatabaseCamera short_camera = MakeDatabaseCamera();
  short_camera.camera.params.pop_back();
  EXPECT_ERROR_HAS(edit.InsertCamera(9, short_camera), "4 parameters of SIMPLE_RADIAL");
  EXPECT_ERROR_HAS(edit.InsertImage(12, MakeDatabaseImage("new.jpg")), "insert image 12 'new.jpg'");
  EXPECT_ERROR_HAS(edit.InsertImage(13, MakeDatabaseImage("a.jpg")), "UNIQUE");
  EXPECT_ERROR_HAS(edit.InsertImage(13, MakeDatabaseImage("")), "names are not empty");
  EXPECT_ERROR_HAS(edit.InsertImage(0, MakeDatabaseImage("new.jpg")), "ids are 1 to 2147483646");
  EXPECT_ERROR_HAS(edit.InsertImage(kMaxImageId + 1, MakeDatabaseImage("new.jpg")), "ids are 1");
  EXPECT_ERROR_HAS(edit.InsertImage(13, {"new.jpg", 99, {}}), "of camera 99");
  EXPECT_ERROR_HAS(edit.SetPositionPrior(99, {1, 2, 3}), "image 99");
  EXPECT_ERROR_HAS(edit.SetPositionPrior(5, {1, 2, std::nan("")}), "no finite number");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(12, MakeKeypoints(3, 6)), "keypoints of image 12");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(99, MakeKeypoints(3, 6)), "keypoints of image 99");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(5, MakeKeypoints(3, 5)), "5 columns");
  EXPECT_ERROR_HAS(edit.InsertMatches({12, 5}, {}), "matches of images 12 and 5");
  EXPECT_ERROR_HAS(edit.InsertMatches({5, 5}, {}), "no pair");
  EXPECT_NO_THROW(edit.InsertImage(13, MakeDatabaseImage("new.jpg")));
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

}  // namespace
}  // namespace colmap_ext
