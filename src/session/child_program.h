// A program that runs beside the session and ends with it.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "colmap_ext/util/child_process.h"

namespace colmap_ext {

class ChildProgram {
 public:
  // Starts it; what it prints goes to `log_path`, which is emptied first.
  ChildProgram(std::vector<std::string> arguments, std::filesystem::path log_path);
  // Ends it at once, if it still runs.
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  bool IsRunning() const { return !has_ended_; }
  // Why it ended: its last line. Throws Error naming the program.
  [[noreturn]] void FailWithLastLine() const;
  // The first whole line that begins with `beginning`, waiting for it at most `timeout_s`. Throws
  // Error when the program ends before, or in that time says no such line; CancelledError.
  std::string WaitForLine(const std::string& beginning, double timeout_s,
                          const JobControl& job) const;

 private:
  void Run(std::vector<std::string> arguments);

  std::string name_;
  std::filesystem::path log_path_;
  std::atomic<bool> cancel_ = false;
  std::atomic<bool> has_ended_ = false;
  std::string failure_;  // of starting it; written before has_ended_
  std::jthread thread_;
};

// The program of this name in the folder of the running one, else on the PATH. Throws Error.
std::filesystem::path FindSibling(const std::string& name);

}  // namespace colmap_ext
