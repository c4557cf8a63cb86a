// --log_format json: what a script reads from any program.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {
namespace {

using nlohmann::json;
using JsonLog = ProgramTest;

// Every line that begins like an object; the commands of these tests print no such line on stdout.
std::vector<json> EventsOf(const std::string& output) {
  std::vector<json> events;
  std::istringstream stream(output);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('{')) events.push_back(json::parse(line));
  }
  return events;
}

constexpr const char* kVerbs[] = {
    "sparse_updater",     "superpixel_segmenter", "superpixel_stereo",   "surface_reconstructor",
    "coverage_evaluator", "view_planner",         "path_planner",        "flight_planner",
    "mission_exporter",   "active_capture",       "dense_reconstructor", "scene_renderer",
    "model_evaluator",    "report_generator",     "flight_client"};

TEST_F(JsonLog, EveryCommandTellsAMistakeAsAnObject) {
  for (const char* verb : kVerbs) {
    const ChildProcessResult result = Run({verb, "--no_such_option", "1", "--log_format", "json"});
    EXPECT_EQ(result.exit_code, 2) << verb;
    const std::vector<json> events = EventsOf(result.output);
    ASSERT_EQ(events.size(), 3u) << result.output;
    EXPECT_EQ(events[0]["event"], "start");
    EXPECT_EQ(events[0]["program"], std::string("colmap_ext ") + verb);
    EXPECT_EQ(events[1]["event"], "error");
    EXPECT_EQ(events[1]["kind"], "usage");
    EXPECT_NE(events[1]["message"].get<std::string>().find("no_such_option"), std::string::npos);
    EXPECT_EQ(events[2]["event"], "end");
    EXPECT_EQ(events[2]["exit_code"], 2);
  }
}

TEST_F(JsonLog, AllLinesOfAWorkingCommandAreObjects) {
  WriteFileAtomically(folder_ / "poses.txt", "a.jpg 0 -12 3 0 -10\nb.jpg 3 -12 3 0 -10\n");
  const ChildProcessResult result = Run({"scene_renderer", "--scene", "boxes", "--pose_list_path",
                                         (folder_ / "poses.txt").string(), "--output_path",
                                         (folder_ / "out").string(), "--log_format=json"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  std::istringstream stream(result.output);
  std::size_t lines = 0;
  for (std::string line; std::getline(stream, line);) ++lines;
  const std::vector<json> events = EventsOf(result.output);
  EXPECT_EQ(events.size(), lines) << result.output;
  ASSERT_GE(events.size(), 4u);
  bool has_progress = false;
  for (const json& event : events) {
    EXPECT_EQ(event["time"].get<std::string>().size(), 24u);
    if (event["event"] != "progress") continue;
    has_progress = true;
    EXPECT_EQ(event["stage"], "rendering");
    EXPECT_EQ(event["total"], 2);
  }
  EXPECT_TRUE(has_progress);
  const json& outcome = events[events.size() - 2];
  EXPECT_EQ(outcome["event"], "result");
  EXPECT_EQ(outcome["photos"], 2);
  EXPECT_EQ(events.back()["exit_code"], 0);
}

TEST_F(JsonLog, AnIniFileMayAskForIt) {
  WriteFileAtomically(folder_ / "o.ini", "log_format = json\n");
  const ChildProcessResult result =
      Run({"report_generator", "--project_path", (folder_ / "o.ini").string(), "--workspace_path",
           (folder_ / "nowhere").string()});
  EXPECT_EQ(result.exit_code, 1);
  const std::vector<json> events = EventsOf(result.output);
  ASSERT_EQ(events.size(), 2u) << result.output;
  EXPECT_EQ(events[0]["event"], "error");
  EXPECT_EQ(events[0]["kind"], "failed");
  EXPECT_EQ(events[1]["exit_code"], 1);
}

TEST_F(JsonLog, OtherFormatsAreRefused) {
  ExpectFailure(Run({"report_generator", "--workspace_path", "w", "--log_format", "xml"}), 2,
                {"--log_format xml", "text or json"});
}

}  // namespace
}  // namespace colmap_ext
