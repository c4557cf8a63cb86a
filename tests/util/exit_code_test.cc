#include "colmap_ext/util/exit_code.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <system_error>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

struct Outcome {
  int code = 0;
  std::string errors;
};

Outcome OutcomeOf(const std::function<int()>& run) {
  testing::internal::CaptureStderr();
  const int code = ExitCodeOf("tool", run);
  return {code, testing::internal::GetCapturedStderr()};
}

TEST(ExitCode, OfTheRunItself) {
  const Outcome outcome = OutcomeOf([] { return 7; });
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(outcome.errors, "");
}

TEST(ExitCode, OneLineForEveryException) {
  const Outcome misuse = OutcomeOf([]() -> int { throw UsageError("--x is no number"); });
  EXPECT_EQ(misuse.code, 2);
  EXPECT_EQ(misuse.errors, "tool: --x is no number\n");
  const Outcome failure = OutcomeOf([]() -> int { throw Error("a.ply: is empty"); });
  EXPECT_EQ(failure.code, 1);
  EXPECT_EQ(failure.errors, "tool: a.ply: is empty\n");
  const Outcome memory = OutcomeOf([]() -> int { throw std::bad_alloc(); });
  EXPECT_EQ(memory.code, 1);
  EXPECT_EQ(memory.errors, "tool: not enough memory\n");
  const Outcome threads = OutcomeOf([]() -> int {
    throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
  });
  EXPECT_EQ(threads.code, 1);
  EXPECT_EQ(threads.errors, "tool: not enough memory, or threads, to start a thread\n");
  const Outcome system = OutcomeOf([]() -> int {
    throw std::system_error(std::make_error_code(std::errc::permission_denied), "/dev/x");
  });
  EXPECT_EQ(system.errors, "tool: /dev/x: Permission denied\n");
  EXPECT_EQ(OutcomeOf([]() -> int { throw std::runtime_error("odd"); }).code, 1);
}

}  // namespace
}  // namespace colmap_ext
