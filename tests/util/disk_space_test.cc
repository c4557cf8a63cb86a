#include "colmap_ext/util/disk_space.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

TEST(DiskSpace, OfAFolderThatIsNotThereYet) {
  const auto here = FreeDiskBytes(testing::TempDir());
  EXPECT_GT(here, 0u);
  const auto later = FreeDiskBytes(std::filesystem::path(testing::TempDir()) / "no" / "such");
  EXPECT_LT(std::max(here, later) - std::min(here, later), 1'000'000'000u) << "the same disk";
}

TEST(DiskSpace, OfAllFilesBelowAFolder) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "disk_space_test";
  WriteFileAtomically(folder / "a", std::string(1000, 'x'));
  WriteFileAtomically(folder / "sub" / "b", std::string(234, 'x'));
  EXPECT_EQ(FolderBytes(folder), 1234u);
  std::filesystem::remove_all(folder);
  EXPECT_EQ(FolderBytes(folder), 0u);
}

TEST(DiskSpace, ComplaintNamesFolderNeedAndRoom) {
  EXPECT_EQ(DiskSpaceComplaint("out", "the dense model", 10, 10), "");
  EXPECT_EQ(DiskSpaceComplaint("out", "the dense model", 7'000'000'000, 6'900'000'000),
            "out: not enough room on this disk: the dense model needs about 7.0 GB, 6.9 GB are "
            "free; make room, or choose a folder on another disk");
}

TEST(DiskSpace, TextForPeople) {
  EXPECT_EQ(BytesText(0), "0 kB");
  EXPECT_EQ(BytesText(999'400), "999 kB");
  EXPECT_EQ(BytesText(999'600), "1 MB");
  EXPECT_EQ(BytesText(812'000'000), "812 MB");
  EXPECT_EQ(BytesText(1'449'000'000), "1.4 GB");
}

}  // namespace
}  // namespace colmap_ext
