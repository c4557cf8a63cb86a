// Databases that are damaged, foreign, or of another version.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/small_database.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Access = Database::Access;

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

// ---- An older schema.

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
