#include "colmap_ext/util/text.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

TEST(FormatNumber, AsPrintf) {
  EXPECT_EQ(FormatNumber("%.2f m", 1.005e3), "1005.00 m");
  EXPECT_EQ(FormatNumber("%gmm", 25.4), "25.4mm");
  EXPECT_EQ(FormatNumber("%.0f", 1e200).size(), 63u) << "cut, not overrun";
}

TEST(SplitAtCommas, KeepsEmptyPartsButTheLast) {
  using Parts = std::vector<std::string>;
  EXPECT_EQ(SplitAtCommas("church, boxes,gate"), (Parts{"church", " boxes", "gate"}));
  EXPECT_EQ(SplitAtCommas("a,,b"), (Parts{"a", "", "b"}));
  EXPECT_EQ(SplitAtCommas("a,"), Parts{"a"});
  EXPECT_EQ(SplitAtCommas(""), Parts{});
}

}  // namespace
}  // namespace colmap_ext
