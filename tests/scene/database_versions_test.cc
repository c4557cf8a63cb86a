// Databases in the schema of every version: each is read and written as that COLMAP does.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/database_schemas.h"
#include "sqlite_rows.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Access = Database::Access;
using Rows = std::vector<std::string>;

class EveryVersion : public testing::TestWithParam<SchemaOfVersion> {
 protected:
  Database Make(const std::string& name = "d.db") {
    return MakeDatabaseOf(folder_ / name, GetParam());
  }

  TestFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Database, EveryVersion,
                         testing::Values(kSchema38, kSchema310, kSchema312, kSchema42),
                         [](const auto& info) { return info.param.name; });

TEST_P(EveryVersion, WhatIsWrittenComesBack) {
  const Database database = Make();
  EXPECT_EQ(database.user_version(), GetParam().user_version);
  EXPECT_EQ(database.has_frames(), GetParam().has_frames);
  EXPECT_EQ(database.ReadCameras().at(7).camera.params, MakeDatabaseCamera().camera.params);
  const auto images = database.ReadImages();
  ASSERT_EQ(images.size(), 2u);
  ASSERT_TRUE(images.at(12).prior.has_value());
  EXPECT_EQ(images.at(12).prior->position, Eigen::Vector3d(47.5, 8.25, 431.125));
  EXPECT_FALSE(images.at(5).prior.has_value());
  EXPECT_EQ(database.ReadKeypoints(12), MakeKeypoints(30, 6));
  EXPECT_EQ(database.ReadDescriptors(5), MakeDescriptors(40));
  EXPECT_EQ(database.ReadMatches({12, 5}), (std::vector<KeypointMatch>{{1, 0}, {3, 2}, {29, 39}}));
  const auto geometry = database.ReadTwoViewGeometry({5, 12});
  EXPECT_EQ(geometry->F, MakeGeometry().F);
  EXPECT_EQ(geometry->H, MakeGeometry().H);
  ASSERT_TRUE(geometry->cam2_from_cam1.has_value());
  EXPECT_EQ(geometry->cam2_from_cam1->translation, Eigen::Vector3d(1, 2, 3));
}

TEST_P(EveryVersion, PriorsAreSetReplacedAndKeepTheirFrame) {
  Database database = Make();
  {
    Database::Transaction edit(database);
    edit.SetPositionPrior(5, {47, 8, -3});
    edit.SetPositionPrior(12, {1, 2, 3}, PriorFrame::kCartesian);
    EXPECT_ERROR_HAS(edit.SetPositionPrior(99, {1, 2, 3}), "no image 99");
    EXPECT_ERROR_HAS(edit.SetPositionPrior(5, {1, std::nan(""), 3}), "no finite number");
    edit.Commit();
  }
  const auto images = database.ReadImages();
  EXPECT_EQ(images.at(5).prior->position, Eigen::Vector3d(47, 8, -3));
  EXPECT_EQ(images.at(12).prior->position, Eigen::Vector3d(1, 2, 3));
  const bool says = GetParam().prior_has_frame;
  EXPECT_EQ(images.at(5).prior->frame, says ? PriorFrame::kWgs84 : PriorFrame::kUnknown);
  EXPECT_EQ(images.at(12).prior->frame, says ? PriorFrame::kCartesian : PriorFrame::kUnknown);
}

TEST_P(EveryVersion, CamerasAreReplaced) {
  Database database = Make();
  Database::Transaction edit(database);
  const DatabaseCamera refined{{CameraModel::kPinhole, 320, 184, {1, 2, 3, 4}}, false};
  edit.UpdateCamera(7, refined);
  EXPECT_ERROR_HAS(edit.UpdateCamera(8, refined), "has no camera 8");
  DatabaseCamera wrong = refined;
  wrong.camera.params.pop_back();
  EXPECT_ERROR_HAS(edit.UpdateCamera(7, wrong), "4 parameters of PINHOLE");
  edit.Commit();
  const DatabaseCamera camera = database.ReadCameras().at(7);
  EXPECT_EQ(camera.camera.model, CameraModel::kPinhole);
  EXPECT_EQ(camera.camera.width, 320);
  EXPECT_EQ(camera.camera.params, refined.camera.params);
  EXPECT_FALSE(camera.has_prior_focal_length);
  EXPECT_EQ(database.ReadImages().size(), 2u);
}

TEST_P(EveryVersion, GeometryThatWasNotEstimatedStaysUnknown) {
  Database database = Make();
  {
    Database::Transaction edit(database);
    edit.InsertImage(13, {"c.jpg", 7, std::nullopt});
    TwoViewGeometry planar;
    planar.config = TwoViewConfig::kPlanar;
    planar.H = MakeGeometry().H;
    edit.InsertTwoViewGeometry({5, 13}, planar);
    edit.Commit();
  }
  const auto geometry = database.ReadTwoViewGeometry({5, 13});
  EXPECT_FALSE(geometry->cam2_from_cam1.has_value());
  EXPECT_TRUE(geometry->E.isZero(0));
  EXPECT_EQ(geometry->H, MakeGeometry().H);
  const std::string zero(64, '0');
  const std::string one = "000000000000F03F";
  const std::string stored =
      Query(folder_ / "d.db", "SELECT hex(qvec) FROM two_view_geometries WHERE config = 4").at(0);
  if (GetParam().user_version == 3800) {
    EXPECT_EQ(stored, zero);
  } else if (GetParam().user_version == 3900) {
    EXPECT_EQ(stored, one + zero.substr(16));
  } else {
    EXPECT_EQ(stored, "");  // NULL: zeros would be taken for a pose
  }
}

TEST_P(EveryVersion, WithoutCommitNothingStays) {
  Database database = Make();
  const auto count = [&] {
    Rows rows;
    for (const std::string& table :
         Query(folder_ / "d.db", "SELECT name FROM sqlite_master WHERE type = 'table'")) {
      if (table == "sqlite_sequence") continue;
      rows.push_back(Query(folder_ / "d.db", "SELECT count(*) FROM " + table).at(0));
    }
    return rows;
  };
  const Rows before = count();
  {
    Database::Transaction edit(database);
    edit.InsertCamera(8, MakeDatabaseCamera());
    edit.InsertImage(13, MakeDatabaseImage("c.jpg"));
    edit.SetPositionPrior(5, {1, 2, 3});
  }
  EXPECT_EQ(count(), before);
}

TEST_P(EveryVersion, WhatContradictsTheDatabaseIsAnError) {
  Database database = Make();
  Database::Transaction edit(database);
  EXPECT_ERROR_HAS(edit.InsertCamera(7, MakeDatabaseCamera()), "insert camera 7");
  EXPECT_ERROR_HAS(edit.InsertImage(12, MakeDatabaseImage("new.jpg")), "insert image 12 'new.jpg'");
  EXPECT_ERROR_HAS(edit.InsertImage(13, {"new.jpg", 99, {}}), "of camera 99");
  EXPECT_ERROR_HAS(edit.InsertKeypoints(99, MakeKeypoints(3, 6)), "keypoints of image 99");
  EXPECT_ERROR_HAS(edit.InsertDescriptors(5, MakeDescriptors(3)), "descriptors of image 5");
  EXPECT_ERROR_HAS(edit.InsertTwoViewGeometry({12, 5}, {}), "geometry of images 12 and 5");
}

TEST_P(EveryVersion, ReadOnlyAndLockedDatabasesAreErrors) {
  Database database = Make();
  Database reader = Database::Open(folder_ / "d.db", Access::kReadOnly);
  EXPECT_ERROR_HAS(Database::Transaction edit(reader), "d.db: cannot be edited");
  Database other = Database::Open(folder_ / "d.db", Access::kReadWrite);
  Database::Transaction edit(database);
  EXPECT_ERROR_HAS(Database::Transaction second(other), "another program uses the database");
}

TEST_P(EveryVersion, TruncatedAtAnyPageIsAnError) {
  Make();
  RunSql(folder_ / "d.db", "PRAGMA journal_mode = WAL");  // as COLMAP leaves it
  for (std::size_t size = fs::file_size(folder_ / "d.db") - 4096; size > 0; size -= 4096) {
    fs::resize_file(folder_ / "d.db", size);
    EXPECT_ERROR_HAS(ReadAll(folder_ / "d.db"), "d.db");
  }
}

TEST_P(EveryVersion, DamagedBytesNeverCrash) {
  Make();
  const std::string content = ReadFile(folder_ / "d.db");
  std::fstream file(folder_ / "d.db", std::ios::binary | std::ios::in | std::ios::out);
  std::mt19937_64 random(9);
  int num_errors = 0;
  for (int i = 0; i < 400; ++i) {
    const auto offset = static_cast<std::streamoff>(random() % content.size());
    file.seekp(offset).put(static_cast<char>(random())).flush();
    try {
      ReadAll(folder_ / "d.db");
    } catch (const Error& error) {
      EXPECT_HAS(error.what(), "d.db");
      ++num_errors;
    }
    file.seekp(offset).put(content[static_cast<std::size_t>(offset)]).flush();
  }
  EXPECT_GT(num_errors, 3);
  EXPECT_NO_THROW(ReadAll(folder_ / "d.db"));
}

TEST_P(EveryVersion, EveryMissingTableIsNamed) {
  std::vector<std::string> tables = {"keypoints", "descriptors", "matches", "two_view_geometries"};
  if (GetParam().has_frames) tables.insert(tables.end(), {"rigs", "rig_sensors", "frame_data"});
  for (const std::string& table : tables) {
    Make(table + ".db");
    RunSql(folder_ / (table + ".db"), "PRAGMA foreign_keys = OFF; DROP TABLE " + table);
    EXPECT_ERROR_HAS(ReadAll(folder_ / (table + ".db")), "no table '" + table + "'");
  }
}

TEST_P(EveryVersion, ATableThatAsksForMoreThanWeKnowIsReadButNotEdited) {
  Make();
  RunSql(folder_ / "d.db",
         "ALTER TABLE keypoints RENAME TO old; CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY "
         "NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB, detector TEXT NOT "
         "NULL); INSERT INTO keypoints SELECT image_id, rows, cols, data, 'x' FROM old;"
         "DROP TABLE old");
  EXPECT_NO_THROW(ReadAll(folder_ / "d.db"));
  Database database = Database::Open(folder_ / "d.db", Access::kReadWrite);
  EXPECT_ERROR_HAS(Database::Transaction edit(database), "'keypoints.detector'");
}

// ---- Rigs and frames.

class VersionWithFrames : public EveryVersion {};
INSTANTIATE_TEST_SUITE_P(Database, VersionWithFrames, testing::Values(kSchema312, kSchema42),
                         [](const auto& info) { return info.param.name; });

TEST_P(VersionWithFrames, ACameraIsARigAndAPhotoAFrame) {
  Make();
  const fs::path path = folder_ / "d.db";
  EXPECT_EQ(Query(path, "SELECT rig_id, ref_sensor_id, ref_sensor_type FROM rigs"), Rows{"7|7|0"});
  EXPECT_TRUE(Query(path, "SELECT * FROM rig_sensors").empty());
  EXPECT_EQ(Query(path, "SELECT frame_id, rig_id FROM frames ORDER BY 1"), (Rows{"5|7", "12|7"}));
  EXPECT_EQ(
      Query(path, "SELECT frame_id, data_id, sensor_id, sensor_type FROM frame_data ORDER BY 1"),
      (Rows{"5|5|7|0", "12|12|7|0"}));
  const FrameTable table = Database::Open(folder_ / "d.db", Access::kReadOnly).ReadFrameTable();
  ASSERT_EQ(table.rigs.size(), 1u);
  EXPECT_EQ(table.rigs.at(7).reference, (SensorId{SensorType::kCamera, 7}));
  ASSERT_EQ(table.frames.size(), 2u);
  EXPECT_EQ(table.frames.at(12).rig_id, 7u);
  EXPECT_EQ(table.frames.at(12).data.at(0).id, 12u);
}

TEST_P(VersionWithFrames, IdsThatAreTakenAreFollowedByTheNextFreeOne) {
  Database database = Make();
  RunSql(folder_ / "d.db",
         "INSERT INTO cameras VALUES(30, 0, 10, 10, x'', 1); INSERT INTO rigs VALUES(8, 30, 0);"
         "INSERT INTO frames VALUES(13, 8)");
  Database::Transaction edit(database);
  edit.InsertCamera(8, MakeDatabaseCamera());
  edit.InsertImage(13, {"c.jpg", 8, std::nullopt});
  edit.Commit();
  const fs::path path = folder_ / "d.db";
  EXPECT_EQ(Query(path, "SELECT rig_id FROM rigs WHERE ref_sensor_id = 8"), Rows{"9"});
  EXPECT_EQ(Query(path, "SELECT frame_id, data_id, sensor_id FROM frame_data WHERE data_id = 13"),
            Rows{"14|13|8"});
  EXPECT_EQ(Query(path, "SELECT rig_id FROM frames WHERE frame_id = 14"), Rows{"9"});
}

TEST_P(VersionWithFrames, AnUnknownUncertaintyIsNotZero) {
  Make();
  const std::string nan = "000000000000F87F";
  std::string nans;
  for (int i = 0; i < 9; ++i) nans += nan;
  EXPECT_EQ(Query(folder_ / "d.db", "SELECT hex(position_covariance) FROM pose_priors"),
            Rows{nans});
  if (GetParam().user_version == 3900) return;
  EXPECT_EQ(Query(folder_ / "d.db",
                  "SELECT corr_data_id, corr_sensor_id, corr_sensor_type, hex(gravity) "
                  "FROM pose_priors"),
            Rows{"12|7|0|" + nan + nan + nan});
  EXPECT_EQ(Query(folder_ / "d.db", "SELECT DISTINCT type FROM descriptors"), Rows{"0"});
}

// Camera 9 stands 0.5 m beside camera 7 in its rig; a photo of each in frame 5, an inertial sensor.
constexpr char kStereoRig[] =
    "INSERT INTO cameras SELECT 9, model, width, height, params, 1 FROM cameras;"
    "INSERT INTO rig_sensors VALUES(7, 9, 0, "
    "x'000000000000F03F000000000000000000000000000000000000000000000000000000000000E03F"
    "00000000000000000000000000000000'), (7, 3, 1, NULL);"
    "INSERT INTO images(image_id, name, camera_id) VALUES(6, 'right.jpg', 9);"
    "INSERT INTO frame_data VALUES(5, 6, 9, 0), (5, 1000, 3, 1);";

TEST_P(VersionWithFrames, RigsOfSeveralSensorsAreRead) {
  Make();
  RunSql(folder_ / "d.db", kStereoRig);
  const FrameTable table = Database::Open(folder_ / "d.db", Access::kReadOnly).ReadFrameTable();
  const Rig& rig = table.rigs.at(7);
  ASSERT_EQ(rig.sensor_from_rig.size(), 2u);
  const auto& pose = rig.sensor_from_rig.at({SensorType::kCamera, 9});
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->translation, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_FALSE(rig.sensor_from_rig.at({SensorType::kImu, 3}).has_value());
  EXPECT_EQ(table.frames.at(5).data.size(), 3u);
}

TEST_P(VersionWithFrames, APhotoOfACameraInARigGetsAFrameOfThatRig) {
  Database database = Make();
  RunSql(folder_ / "d.db", kStereoRig);
  Database::Transaction edit(database);
  edit.InsertImage(20, {"right2.jpg", 9, std::nullopt});
  edit.Commit();
  EXPECT_EQ(database.ReadFrameTable().frames.at(20).rig_id, 7u);
  EXPECT_EQ(database.ReadFrameTable().rigs.size(), 1u);
}

TEST_P(VersionWithFrames, FramesThatContradictThemselvesAreErrors) {
  const std::pair<const char*, const char*> cases[] = {
      {"UPDATE frames SET rig_id = 99 WHERE frame_id = 5", "frame 5 is of rig 99"},
      {"UPDATE frame_data SET frame_id = 99 WHERE data_id = 5", "a frame that does not exist"},
      {"UPDATE frame_data SET sensor_id = 99 WHERE data_id = 5", "frame 5 has data of camera 99"},
      {"UPDATE frame_data SET sensor_type = 7", "column sensor_type holds 7"},
      {"INSERT INTO rig_sensors VALUES(99, 9, 0, NULL)", "a rig that does not exist"},
      {"INSERT INTO rig_sensors VALUES(7, 9, 0, x'0011')", "2 bytes, not 56"},
      {"INSERT INTO rig_sensors VALUES(7, 9, 0, zeroblob(56))", "no rotation"},
      {"INSERT INTO rig_sensors VALUES(7, 7, 0, NULL)", "camera 7 twice"},
  };
  int i = 0;
  for (const auto& [sql, message] : cases) {
    const std::string name = std::to_string(i++) + ".db";
    Make(name);
    RunSql(folder_ / name, sql);
    EXPECT_ERROR_HAS(ReadAll(folder_ / name), message);
    EXPECT_ERROR_HAS(ReadAll(folder_ / name), name);
  }
}

TEST_P(VersionWithFrames, APriorOfAnotherSensorIsNotThePhotos) {
  if (GetParam().user_version == 3900) GTEST_SKIP() << "its priors are of photos only";
  Make();
  RunSql(folder_ / "d.db", "UPDATE pose_priors SET corr_sensor_type = 1");
  const Database database = Database::Open(folder_ / "d.db", Access::kReadOnly);
  EXPECT_FALSE(database.ReadImages().at(12).prior.has_value());
}

}  // namespace
}  // namespace colmap_ext
