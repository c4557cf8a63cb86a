// The real `colmap`, for tests that read what it wrote and let it read what we wrote.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "scene/test_folder.h"

namespace colmap_ext {

inline bool HasColmap() { return !FindProgram("colmap").empty(); }

// Runs `colmap` with these arguments, without display, and expects success.
inline void RunColmap(const std::vector<std::string>& arguments) {
  ChildProcessOptions options;
  options.arguments = {"colmap"};
  options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}, {"OMP_WAIT_POLICY", "passive"}};
  const ChildProcessResult result = RunChildProcess(options, JobControl());
  ASSERT_EQ(result.exit_code, 0) << result.output;
}

// The message of the Error that `function` throws; a failed expectation when it throws none.
template <typename Function>
std::string ErrorOf(Function&& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

#define EXPECT_HAS(text, part) \
  EXPECT_PRED_FORMAT2(::testing::IsSubstring, std::string(part), std::string(text))
#define EXPECT_ERROR_HAS(statement, part) \
  EXPECT_HAS(::colmap_ext::ErrorOf([&] { statement; }), part)

}  // namespace colmap_ext
