// What a script relies on: --dry_run, --status, hooks, the lock, changes that are named at resume.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session_lock.h"
#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SessionCommands : public ProgramTest {
 protected:
  std::vector<std::string> Arguments(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"active_capture",
                                          "--workspace_path",
                                          (folder_ / "w").string(),
                                          "--scene",
                                          "boxes",
                                          "--Session.vehicle",
                                          "embedded",
                                          "--InitialFlight.num_views",
                                          "24",
                                          "--Session.pictures",
                                          "0",
                                          "--Session.max_iterations",
                                          "1",
                                          "--SparseUpdate.max_num_features",
                                          "1500",
                                          "--Renderer.samples_per_pixel",
                                          "1",
                                          "--ModelEvaluator.sample_spacing_m",
                                          "0.05"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::vector<json> Events(const std::string& output, const std::string& kind) const {
    std::vector<json> events;
    std::istringstream stream(output);
    for (std::string line; std::getline(stream, line);) {
      if (!line.starts_with('{')) continue;
      const json event = json::parse(line);
      if (event["event"] == kind) events.push_back(event);
    }
    return events;
  }
};

void SetMaxIterations(const std::string& number, std::vector<std::string>* arguments) {
  *std::next(std::ranges::find(*arguments, "--Session.max_iterations")) = number;
}

bool Has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

TEST_F(SessionCommands, DryRunSaysWhatWouldBeDoneAndWritesNothing) {
  const ChildProcessResult result = Run(Arguments({"--dry_run"}));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(Has(result.output, "24 new")) << result.output;
  EXPECT_TRUE(Has(result.output, "sparse superpixels stereo fusion surface coverage nbv path"));
  EXPECT_TRUE(Has(result.output, "flight:"));
  EXPECT_TRUE(Has(result.output, "nothing was written"));
  EXPECT_TRUE(fs::is_empty(folder_));
  const ChildProcessResult as_json = Run(Arguments({"--dry_run", "--log_format", "json"}));
  const std::vector<json> results = Events(as_json.output, "result");
  ASSERT_EQ(results.size(), 1u) << as_json.output;
  EXPECT_EQ(results[0]["new_photos"], 24);
  EXPECT_GT(results[0]["flight_length_m"], 5.0);
  EXPECT_GT(results[0]["disk_next_bytes"], 1000000);
}

TEST_F(SessionCommands, StatusOfNothing) {
  ExpectFailure(Run({"active_capture", "--status", "--workspace_path", folder_.string()}), 1,
                {folder_.string(), "no session"});
  ExpectFailure(Run({"active_capture", "--status", "--workspace_path", "/nowhere"}), 1,
                {"/nowhere", "no such folder"});
}

TEST_F(SessionCommands, TheSecondSessionIsRefused) {
  fs::create_directories(folder_ / "w");
  const SessionLock lock{Workspace(folder_ / "w")};
  ExpectFailure(Run(Arguments({})), 1,
                {"a session is running in this workspace", std::to_string(getpid())});
  EXPECT_FALSE(fs::exists(folder_ / "w" / "session.ini")) << "the first one's options";
  const ChildProcessResult status =
      Run({"active_capture", "--status", "--workspace_path", (folder_ / "w").string()});
  EXPECT_EQ(status.exit_code, 0);
  EXPECT_TRUE(Has(status.output, "yes, process " + std::to_string(getpid()))) << status.output;
}

// One session told in order, because each step costs seconds.
TEST_F(SessionCommands, HooksStatusAndChangesOfASession) {
  const std::string hook =
      "echo \"$COLMAP_EXT_ITERATION $COLMAP_EXT_PHOTOS $COLMAP_EXT_FINISHED\" > " +
      (folder_ / "hooked").string() + "; test -d \"$COLMAP_EXT_ITERATION_PATH/sparse\"";
  const ChildProcessResult first = Run(Arguments(
      {"--log_format", "json", "--on_iteration", hook, "--on_finish", "echo done; exit 7"}));
  EXPECT_EQ(first.exit_code, 1) << "the last hook failed";
  EXPECT_EQ(ReadFile(folder_ / "hooked"), "0 24 iteration_limit\n");
  const std::vector<json> errors = Events(first.output, "error");
  ASSERT_EQ(errors.size(), 1u) << first.output;
  EXPECT_TRUE(Has(errors[0]["message"], "--on_finish")) << errors[0];
  EXPECT_TRUE(Has(errors[0]["message"], "exit code 7"));
  EXPECT_EQ(ReadFile(folder_ / "w" / "logs" / "on_finish.log"), "done\n");
  std::vector<std::string> stages;
  for (const json& stage : Events(first.output, "stage")) stages.push_back(stage["stage"]);
  EXPECT_EQ(stages,
            (std::vector<std::string>{"capture", "sparse", "superpixels", "stereo", "fusion",
                                      "surface", "coverage", "nbv", "path", "evaluation"}));
  const std::vector<json> iterations = Events(first.output, "iteration");
  ASSERT_EQ(iterations.size(), 1u);
  EXPECT_EQ(iterations[0]["photos"], 24);
  EXPECT_EQ(iterations[0]["finished"], "iteration_limit");

  const ChildProcessResult status =
      Run({"active_capture", "--status", "--workspace_path", (folder_ / "w").string()});
  EXPECT_TRUE(Has(status.output, "1 done")) << status.output;
  EXPECT_TRUE(Has(status.output, "24 of 24 registered")) << status.output;
  EXPECT_TRUE(Has(status.output, "covered:")) << status.output;

  // A photo was replaced since, and a limit was raised.
  const fs::path photo = folder_ / "w" / "images" / "view_00003.jpg";
  const std::string bytes = ReadFile(photo);
  WriteFileAtomically(photo, bytes + "x");
  std::vector<std::string> arguments = Arguments({"--dry_run"});
  SetMaxIterations("2", &arguments);
  const ChildProcessResult forecast = Run(arguments);
  EXPECT_TRUE(Has(forecast.output, "view_00003.jpg")) << forecast.output;
  EXPECT_TRUE(Has(forecast.output, "Session.max_iterations: 1 before, 2 now")) << forecast.output;
  EXPECT_TRUE(Has(forecast.output, "iteration 2")) << forecast.output;
}

TEST_F(SessionCommands, AFailingHookStopsAfterAWholeIteration) {
  std::vector<std::string> arguments = Arguments({"--on_iteration", "echo no more; false"});
  SetMaxIterations("3", &arguments);
  ExpectFailure(Run(arguments), 1, {"--on_iteration", "exit code 1", "on_iteration.log"});
  const json state = json::parse(ReadFile(folder_ / "w" / "state.json"));
  EXPECT_EQ(state["iterations_done"], 1);
  EXPECT_EQ(state["finished"], "");
}

}  // namespace
}  // namespace colmap_ext
