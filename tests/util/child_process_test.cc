#include "colmap_ext/util/child_process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

ChildProcessOptions Shell(const std::string& script) {
  ChildProcessOptions options;
  options.arguments = {"sh", "-c", script};
  return options;
}

TEST(ChildProcess, CollectsOutputAndExitCode) {
  const ChildProcessResult result =
      RunChildProcess(Shell("echo out; echo err >&2; exit 3"), JobControl());
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.output.find("out\n"), std::string::npos);
  EXPECT_NE(result.output.find("err\n"), std::string::npos);
}

TEST(ChildProcess, PassesEnvironmentAndArgumentsWithoutAShell) {
  ChildProcessOptions options;
  options.arguments = {"printenv", "COLMAP_EXT_TEST"};
  options.environment["COLMAP_EXT_TEST"] = "$HOME; rm x";
  EXPECT_EQ(RunChildProcess(options, JobControl()).output, "$HOME; rm x\n");
}

TEST(ChildProcess, FixedAddressesAreThoseOfTheRunBefore) {
  ChildProcessOptions options;
  options.arguments = {"cat", "/proc/self/personality"};
  options.fixed_addresses = true;
  const std::string flags = RunChildProcess(options, JobControl()).output;
  if (flags.find("0004") == std::string::npos) GTEST_SKIP() << "not allowed here: " << flags;
  options.arguments = {"cat", "/proc/self/maps"};
  const std::string first = RunChildProcess(options, JobControl()).output;
  EXPECT_EQ(RunChildProcess(options, JobControl()).output, first);
  options.fixed_addresses = false;
  EXPECT_NE(RunChildProcess(options, JobControl()).output, first);
}

TEST(ChildProcess, ReportsSignals) {
  EXPECT_EQ(RunChildProcess(Shell("kill -9 $$"), JobControl()).exit_code, 137);
}

TEST(ChildProcess, MissingProgramIsAnError) {
  ChildProcessOptions options;
  options.arguments = {"no_such_program_here"};
  EXPECT_THROW(RunChildProcess(options, JobControl()), Error);
  EXPECT_TRUE(FindProgram("no_such_program_here").empty());
  EXPECT_FALSE(FindProgram("sh").empty());
}

TEST(ChildProcess, CancelKillsTheChildAndItsChildren) {
  std::atomic<bool> cancel = false;
  const JobControl job(nullptr, &cancel);
  std::jthread canceller([&cancel] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    cancel = true;
  });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(RunChildProcess(Shell("sleep 30 & sleep 30"), job), CancelledError);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(ChildProcess, ChildDiesWithItsParent) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t parent = fork();
  if (parent == 0) {
    close(ends[0]);
    // The grandchild inherits the pipe's end by number: it closes only when the grandchild is gone.
    RunChildProcess(Shell("exec sleep 30 3>&" + std::to_string(ends[1])), JobControl());
    _exit(0);
  }
  close(ends[1]);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  char byte;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(read(ends[0], &byte, 1), 0);  // end of file: nobody holds the other end
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  close(ends[0]);
}

TEST(ChildProcess, MeasuresCpuTime) {
  const ChildProcessResult result =
      RunChildProcess(Shell("i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"), JobControl());
  EXPECT_GT(result.cpu_s, 0.01);
  EXPECT_GT(result.peak_mib, 0.1);
}

}  // namespace
}  // namespace colmap_ext
