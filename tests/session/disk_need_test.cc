#include "session/disk_need.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

constexpr double kMega = 1e6;

// A measured session: the church, 8 iterations from 52 to 148 photos, 403 MB.
TEST(DiskNeed, IsOnTheSafeSideOfAMeasuredSession) {
  StageOptions options;
  options.session.max_iterations = 8;
  options.session.max_photos = 148;
  const DiskNeed need = EstimateDiskNeed(options, true, 0, 52, 0);
  EXPECT_GT(static_cast<double>(need.session_bytes), 403 * kMega);
  EXPECT_LT(static_cast<double>(need.session_bytes), 2 * 403 * kMega);
  EXPECT_GT(static_cast<double>(need.next_bytes), 28 * kMega + 52 * 0.35 * kMega);
  EXPECT_LT(need.next_bytes, need.session_bytes);
}

TEST(DiskNeed, GrowsWithWhatIsWritten) {
  StageOptions options;
  const DiskNeed plain = EstimateDiskNeed(options, true, 50, 10, 3);
  EXPECT_GT(EstimateDiskNeed(options, true, 60, 10, 3).next_bytes, plain.next_bytes);
  EXPECT_GT(EstimateDiskNeed(options, true, 50, 20, 3).next_bytes, plain.next_bytes);
  StageOptions dense = options;
  dense.session.dense_output = true;
  EXPECT_GE(EstimateDiskNeed(dense, true, 50, 10, 3).next_bytes, plain.next_bytes + 5'000'000 * 60);
  StageOptions full = options;
  full.session.full_resolution = true;
  EXPECT_GT(EstimateDiskNeed(full, true, 50, 10, 3).next_bytes, plain.next_bytes);
}

TEST(DiskNeed, TheLastIterationIsAllThatASessionNeeds) {
  StageOptions options;
  options.session.max_iterations = 4;
  const DiskNeed need = EstimateDiskNeed(options, true, 190, 10, 3);
  EXPECT_EQ(need.session_bytes, need.next_bytes);
  const DiskNeed own_photos = EstimateDiskNeed(StageOptions(), false, 0, 100, 0);
  EXPECT_EQ(own_photos.session_bytes, own_photos.next_bytes) << "one call, one iteration";
}

TEST(DiskNeed, OneLineThatSaysWhatToDo) {
  const DiskNeed need{50'000'000, 2'000'000'000};
  EXPECT_EQ(DiskComplaint(need, 50'000'000, "w"), "");
  const std::string complaint = DiskComplaint(need, 49'999'999, "w");
  EXPECT_NE(complaint.find("w: not enough room"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("needs about 50 MB, 50 MB are free"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("make room"), std::string::npos) << complaint;
  EXPECT_EQ(DiskWarning(need, 2'000'000'000, "w"), "");
  EXPECT_NE(DiskWarning(need, 1'900'000'000, "w").find("2.0 GB, 1.9 GB"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
