#include "colmap_ext/util/disk_space.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

TEST(DiskSpace, OfAFolderThatIsNotThereYet) {
  const auto here = FreeDiskBytes(testing::TempDir());
  EXPECT_GT(here, 0u);
  const auto later = FreeDiskBytes(std::filesystem::path(testing::TempDir()) / "no" / "such");
  EXPECT_LT(std::max(here, later) - std::min(here, later), 1'000'000'000u) << "the same disk";
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
