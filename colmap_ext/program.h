// What main() hands to a command.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/util/job_control.h"
#include "program_log.h"

namespace colmap_ext {

struct Program {
  Program(std::string name, const std::vector<std::string>& arguments)
      : log(std::move(name), arguments) {}

  JobControl Job() { return {&log, &cancel}; }

  // Returns what `body` returns, as exit code. What it throws becomes one line of the log, and 2
  // for UsageError, 1 for everything else.
  int Run(const std::vector<std::string>& arguments, const std::function<int()>& body);

  ProgramLog log;
  std::atomic<bool> cancel = false;  // the user asked to stop
};

}  // namespace colmap_ext
