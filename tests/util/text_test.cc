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

TEST(WrapText, BreaksAtSpaces) {
  EXPECT_EQ(WrapText("one two three", 7), "one two\nthree");
  EXPECT_EQ(WrapText("one two three", 100), "one two three");
  EXPECT_EQ(WrapText("a incomprehensibility b", 5), "a\nincomprehensibility\nb");
  EXPECT_EQ(WrapText("", 5), "");
}

TEST(NearestName, SuggestsWhatIsNearEnough) {
  const std::vector<std::string> names = {"view_planner", "path_planner", "report_generator"};
  EXPECT_EQ(NearestName("veiw_planner", names), "view_planner");
  EXPECT_EQ(NearestName("path_planer", names), "path_planner");
  EXPECT_EQ(NearestName("Report_Generator", names), "report_generator");
  EXPECT_EQ(NearestName("mapper", names), "");
  EXPECT_EQ(NearestName("", names), "");
}

}  // namespace
}  // namespace colmap_ext
