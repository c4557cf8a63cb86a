// Runs another program and waits for it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct ChildProcessOptions {
  std::vector<std::string> arguments;              // [0] is the program, looked up on the PATH
  std::map<std::string, std::string> environment;  // added to this process's own
  std::filesystem::path log_path;  // stdout and stderr go there, appended; empty: kept
                                   // only in ChildProcessResult::output
  // The same addresses in every run, where the system allows it: for a program that reads memory it
  // never wrote, whose result would change from run to run.
  bool fixed_addresses = false;
};

struct ChildProcessResult {
  int exit_code = 0;   // 128 + signal when a signal ended it
  std::string output;  // stdout and stderr together, at most the last 1 MiB
  double wall_s = 0;
  double cpu_s = 0;     // user + system
  double peak_mib = 0;  // maximum resident set
};

// Starts the program without a shell, waits, and returns what happened. The child dies with this
// process (also by kill -9), and is killed when `job` is cancelled (CancelledError is thrown then).
// Throws Error when the program cannot be started.
ChildProcessResult RunChildProcess(const ChildProcessOptions& options, const JobControl& job);

// Full path of `program` (a name on the PATH, or a path); empty when there is no such program.
std::filesystem::path FindProgram(const std::string& program);

// The folder that the running program lies in; empty where the system does not tell.
std::filesystem::path FolderOfThisProgram();

}  // namespace colmap_ext
