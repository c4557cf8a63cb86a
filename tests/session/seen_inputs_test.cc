#include "session/seen_inputs.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class SeenInputsTest : public testing::Test {
 protected:
  SeenInputsTest()
      : folder_(fs::path(testing::TempDir()) / ("seen_" + std::to_string(getpid()))),
        photos_(folder_ / "photos"),
        database_(folder_ / "database.db") {
    for (const char* name : {"a.jpg", "b.jpg", "sub/c.jpg", "d.jpg", "e.jpg"}) {
      WriteFileAtomically(photos_ / name, std::string("photo ") + name);
    }
    WriteFileAtomically(database_, "rows");
  }
  ~SeenInputsTest() override { fs::remove_all(folder_); }

  SeenInputs Look(const std::string& ini = "[Session]\nmax_photos = 200\n") const {
    return LookAtInputs(photos_, database_, ini);
  }
  InputChanges Compare(const SeenInputs& before, bool database_is_ours = false) const {
    return CompareInputs(before, Look(), photos_, database_, database_is_ours);
  }

  fs::path folder_, photos_, database_;
};

TEST_F(SeenInputsTest, ComesBackExactly) {
  const SeenInputs seen = Look("[Session]\nmax_photos = 200\n\n[Path]\nfree_volume = a = b\n");
  EXPECT_EQ(seen.options.at("Path.free_volume"), "a = b");
  EXPECT_EQ(seen.photos.size(), 5u);
  WriteSeenInputs(seen, folder_ / "seen.json");
  const SeenInputs read = ReadSeenInputs(folder_ / "seen.json");
  EXPECT_EQ(read.photos, seen.photos);
  EXPECT_EQ(read.database, seen.database);
  EXPECT_EQ(read.options, seen.options);
}

TEST_F(SeenInputsTest, NothingChangedAndNewPhotosAreNoChange) {
  const SeenInputs before = Look();
  WriteFileAtomically(photos_ / "new.jpg", "a photo more");
  const InputChanges changes = Compare(before);
  EXPECT_TRUE(changes.warnings.empty());
  EXPECT_TRUE(changes.notes.empty());
  EXPECT_TRUE(changes.removed_photos.empty());
}

TEST_F(SeenInputsTest, PhotosThatWentOrChangedAreNamed) {
  const SeenInputs before = Look();
  for (const char* name : {"a.jpg", "b.jpg", "d.jpg", "e.jpg"}) fs::remove(photos_ / name);
  WriteFileAtomically(photos_ / "sub/c.jpg", "another photo of this name");
  const InputChanges changes = Compare(before);
  ASSERT_EQ(changes.warnings.size(), 2u);
  EXPECT_NE(changes.warnings[0].find("4 photos"), std::string::npos) << changes.warnings[0];
  EXPECT_NE(changes.warnings[0].find("a.jpg, b.jpg, d.jpg and 1 more"), std::string::npos);
  EXPECT_NE(changes.warnings[1].find("1 photo in"), std::string::npos) << changes.warnings[1];
  EXPECT_NE(changes.warnings[1].find("sub/c.jpg"), std::string::npos);
  EXPECT_EQ(changes.removed_photos, (std::vector<std::string>{"a.jpg", "b.jpg", "d.jpg", "e.jpg"}));
}

TEST_F(SeenInputsTest, AnotherProgramsDatabase) {
  const SeenInputs before = Look();
  WriteFileAtomically(database_, "more rows");
  ASSERT_EQ(Compare(before).warnings.size(), 1u);
  EXPECT_NE(Compare(before).warnings[0].find("another program"), std::string::npos);
  EXPECT_TRUE(Compare(before, true).warnings.empty()) << "an interrupted run of ours wrote it";
  fs::remove(database_);
  EXPECT_NE(Compare(before).warnings[0].find("gone"), std::string::npos);
}

TEST_F(SeenInputsTest, OptionsAreNamedWithBothValues) {
  const SeenInputs before = Look("[Session]\nmax_photos = 100\n");
  const InputChanges changes = Compare(before);
  EXPECT_TRUE(changes.warnings.empty());
  ASSERT_EQ(changes.notes.size(), 1u);
  EXPECT_NE(changes.notes[0].find("Session.max_photos: 100 before, 200 now"), std::string::npos)
      << changes.notes[0];
}

TEST_F(SeenInputsTest, DamagedFilesAreNamed) {
  for (const char* text : {"", "[]", "{\"version\": 2}", "{\"version\": 1}",
                           "{\"version\": 1, \"database\": [1], \"photos\": {}, \"options\": {}}",
                           "{\"version\": 1, \"database\": [1, 2], \"photos\": {\"a\": 1}, "
                           "\"options\": {}}"}) {
    WriteFileAtomically(folder_ / "seen.json", text);
    try {
      ReadSeenInputs(folder_ / "seen.json");
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("seen.json"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace colmap_ext
