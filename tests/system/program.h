// Runs the built program in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/util/child_process.h"

namespace colmap_ext {

class ProgramTest : public ::testing::Test {
 protected:
  ProgramTest() {
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              (std::string("colmap_ext_") + info->test_suite_name() + "_" + info->name() + "_" +
               std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~ProgramTest() override {
    std::error_code ignored;
    std::filesystem::permissions(folder_, std::filesystem::perms::owner_all, ignored);
    std::filesystem::remove_all(folder_, ignored);
  }

  ChildProcessResult Run(std::vector<std::string> arguments,
                         const std::map<std::string, std::string>& environment = {}) const {
    ChildProcessOptions options;
    options.arguments = std::move(arguments);
    options.arguments.insert(options.arguments.begin(), COLMAP_EXT_PROGRAM);
    options.environment = environment;
    return RunChildProcess(options, JobControl());
  }

  // Exit code `code`, and a last line that holds every one of `words`.
  void ExpectFailure(const ChildProcessResult& result, int code,
                     const std::vector<std::string>& words) const {
    EXPECT_EQ(result.exit_code, code) << result.output;
    std::string text = result.output;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    const std::string last = text.substr(text.rfind('\n') + 1);
    for (const std::string& word : words) {
      EXPECT_NE(last.find(word), std::string::npos) << "'" << word << "' is not in: " << last;
    }
  }

  std::filesystem::path folder_;
};

}  // namespace colmap_ext
