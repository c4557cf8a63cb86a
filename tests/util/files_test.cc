#include "colmap_ext/util/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <ostream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {
namespace fs = std::filesystem;

class FilesTest : public testing::Test {
 protected:
  FilesTest() : folder_(fs::path(testing::TempDir()) / ("files_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~FilesTest() override { fs::remove_all(folder_); }

  std::size_t CountEntries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(FilesTest, WritesAndReadsBack) {
  const std::string content("a\0b\n", 4);
  WriteFileAtomically(folder_ / "deep" / "file.bin", content);
  EXPECT_EQ(ReadFile(folder_ / "deep" / "file.bin"), content);
}

TEST_F(FilesTest, KeepsTheOldFileWhenTheWriterFails) {
  WriteFileAtomically(folder_ / "file", "old");
  EXPECT_THROW(WriteFileAtomically(folder_ / "file",
                                   [](std::ostream& stream) {
                                     stream << "half of the new";
                                     throw Error("no more");
                                   }),
               Error);
  EXPECT_EQ(ReadFile(folder_ / "file"), "old");
  EXPECT_EQ(CountEntries(), 1U) << "a temporary file was left behind";
}

TEST_F(FilesTest, ReportsAFullDisk) {
  if (!fs::exists("/dev/full")) return;
  EXPECT_THROW(WriteFileAtomically(folder_ / "file",
                                   [](std::ostream& stream) { stream.setstate(std::ios::badbit); }),
               Error);
  EXPECT_EQ(CountEntries(), 0U);
}

TEST_F(FilesTest, AnEmptyFileIsReadAsEmpty) {
  WriteFileAtomically(folder_ / "empty", "");
  EXPECT_EQ(ReadFile(folder_ / "empty"), "");
}

TEST_F(FilesTest, NamesWhatIsMissing) {
  try {
    RequireFolder(folder_ / "nowhere", "photos");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              (folder_ / "nowhere").string() + ": no such folder (photos)");
  }
  EXPECT_THROW(RequireFile(folder_, "model"), Error);
  EXPECT_THROW(ReadFile(folder_ / "nothing"), Error);
}

TEST_F(FilesTest, ListsPhotosSortedAndRelative) {
  for (const char* name : {"b.JPG", "a.png", "notes.txt", ".hidden.jpg", "sub/c.jpeg"}) {
    WriteFileAtomically(folder_ / name, "x");
  }
  EXPECT_EQ(ListPhotos(folder_), (std::vector<std::string>{"a.png", "b.JPG", "sub/c.jpeg"}));
}

TEST_F(FilesTest, TemporaryNameKeepsTheExtension) {
  EXPECT_EQ(TemporaryPathFor("x/picture.png").extension(), ".png");
  EXPECT_EQ(TemporaryPathFor("x/picture.png").parent_path(), "x");
}

}  // namespace
}  // namespace colmap_ext
