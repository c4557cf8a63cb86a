#include "colmap_ext/util/utc_time.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

TEST(UtcTime, KnownMoments) {
  EXPECT_EQ(UtcText(0, 0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(UtcText(951'782'399'999'999, 3), "2000-02-28T23:59:59.999Z") << "cut, not rounded";
  EXPECT_EQ(UtcText(951'868'800'000'001, 6), "2000-03-01T00:00:00.000001Z") << "after a leap day";
  EXPECT_EQ(UtcText(4'102'444'800'000'000, 1), "2100-01-01T00:00:00.0Z");
}

TEST(UtcTime, TheClockIsInMilliseconds) {
  const std::string now = UtcNow();
  EXPECT_EQ(now.size(), 24u) << now;
  EXPECT_EQ(now[19], '.');
  EXPECT_GT(now, "2026");
}

}  // namespace
}  // namespace colmap_ext
