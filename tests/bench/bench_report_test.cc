#include "support/bench_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

TEST(BenchReport, GoalsAreMetOrNot) {
  BenchReport report("unit_test");
  report.Add("fast enough", 0.9, "ratio", AtMost(1.0));
  report.Add("too few", 0.6, "ratio", AtLeast(0.7));
  report.Add("no goal", 12.0, "s");
  const auto json = nlohmann::json::parse(report.ToJson());
  ASSERT_EQ(json["rows"].size(), 3u);
  EXPECT_EQ(json["rows"][0]["goal"], "<= 1");
  EXPECT_EQ(json["rows"][0]["met"], true);
  EXPECT_EQ(json["rows"][1]["met"], false);
  EXPECT_TRUE(json["rows"][2]["goal"].is_null());
  EXPECT_TRUE(json["rows"][2]["met"].is_null());
  EXPECT_GT(json["machine"]["cores"].get<int>(), 0);
  EXPECT_FALSE(json["commit"].get<std::string>().empty());
  EXPECT_NE(report.ToMarkdown().find("| too few | 0.6 | ratio | >= 0.7 | **no** |"),
            std::string::npos);
}

TEST(BenchReport, MedianOfOddEvenAndNothing) {
  EXPECT_EQ(Median({3, 1, 2}), 2);
  EXPECT_EQ(Median({4, 1, 2, 3}), 2.5);
  EXPECT_THROW(Median({}), Error);
}

}  // namespace
}  // namespace colmap_ext
