#include "colmap_ext/util/json_sink.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace colmap_ext {
namespace {

std::vector<nlohmann::json> LinesOf(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST(JsonSink, MessagesAreObjectsWithTimeAndLevel) {
  JsonSink sink(LogLevel::kInfo);
  testing::internal::CaptureStderr();
  sink.Message(LogLevel::kDebug, "not this");
  sink.Message(LogLevel::kInfo, "two\nlines and \"quotes\"");
  sink.Message(LogLevel::kWarning, "\xff is no UTF-8");
  const auto lines = LinesOf(testing::internal::GetCapturedStderr());
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].at("event"), "message");
  EXPECT_EQ(lines[0].at("level"), "info");
  EXPECT_EQ(lines[0].at("message"), "two\nlines and \"quotes\"");
  const std::string time = lines[0].at("time");
  EXPECT_EQ(time.size(), 24u) << time;
  EXPECT_EQ(time.back(), 'Z');
  EXPECT_EQ(lines[1].at("level"), "warning");
}

TEST(JsonSink, ProgressComesAtEveryTenthAndAtANewStage) {
  JsonSink sink(LogLevel::kInfo);
  testing::internal::CaptureStderr();
  for (std::size_t done = 0; done <= 100; ++done) sink.Progress("matching", done, 100);
  sink.Progress("mapping", 0, 0);
  const auto lines = LinesOf(testing::internal::GetCapturedStderr());
  ASSERT_EQ(lines.size(), 12u);
  EXPECT_EQ(lines[0].at("event"), "progress");
  EXPECT_EQ(lines[0].at("done"), 0);
  EXPECT_EQ(lines[10].at("done"), 100);
  EXPECT_EQ(lines[10].at("total"), 100);
  EXPECT_EQ(lines[11].at("stage"), "mapping");
}

TEST(JsonSink, QuietWhenOnlyWarningsAreWanted) {
  JsonSink sink(LogLevel::kWarning);
  testing::internal::CaptureStderr();
  sink.Progress("matching", 1, 2);
  sink.Message(LogLevel::kInfo, "no");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(JsonSink, EventsAreToldAtEveryLevel) {
  JsonSink sink(LogLevel::kError);
  testing::internal::CaptureStderr();
  sink.Event("result", {{"photos", 3}, {"covered_ratio", 0.5}});
  sink.Event("end", nullptr);
  const auto lines = LinesOf(testing::internal::GetCapturedStderr());
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].at("event"), "result");
  EXPECT_EQ(lines[0].at("photos"), 3);
  EXPECT_EQ(lines[1].size(), 2u) << "time and event";
}

}  // namespace
}  // namespace colmap_ext
