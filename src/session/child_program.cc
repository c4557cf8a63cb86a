#include "session/child_program.h"

#include <chrono>
#include <sstream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

std::string LastLine(const std::string& text) {
  std::string last;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace

ChildProgram::ChildProgram(std::vector<std::string> arguments, std::filesystem::path log_path)
    : name_(std::filesystem::path(arguments.at(0)).filename()), log_path_(std::move(log_path)) {
  WriteFileAtomically(log_path_, "");
  thread_ = std::jthread([this, arguments = std::move(arguments)] { Run(arguments); });
}

ChildProgram::~ChildProgram() { cancel_ = true; }

// The child dies with the thread that started it, so this one waits for it.
void ChildProgram::Run(std::vector<std::string> arguments) {
  ChildProcessOptions options;
  options.arguments = std::move(arguments);
  options.log_path = log_path_;
  try {
    RunChildProcess(options, JobControl(nullptr, &cancel_));
  } catch (const std::exception& error) {
    failure_ = error.what();
  }
  has_ended_ = true;
}

void ChildProgram::FailWithLastLine() const {
  const std::string last = LastLine(ReadFile(log_path_));
  const std::string& reason = last.empty() ? failure_ : last;
  throw Error(name_ + " ended: " + reason + " (all of it: " + log_path_.string() + ")");
}

std::string ChildProgram::WaitForLine(const std::string& beginning, double timeout_s,
                                      const JobControl& job) const {
  constexpr double kPollS = 0.02;
  for (double waited_s = 0; waited_s < timeout_s; waited_s += kPollS) {
    job.ThrowIfCancelled();
    const bool has_ended = has_ended_;
    const std::string text = ReadFile(log_path_);
    std::istringstream stream(text.substr(0, text.rfind('\n') + 1));
    for (std::string line; std::getline(stream, line);) {
      if (line.starts_with(beginning)) return line;
    }
    if (has_ended) FailWithLastLine();
    std::this_thread::sleep_for(std::chrono::duration<double>(kPollS));
  }
  throw Error(name_ + " is not ready after " + std::to_string(static_cast<int>(timeout_s)) +
              " s; what it said: " + log_path_.string());
}

std::filesystem::path FindSibling(const std::string& name) {
  const std::filesystem::path folder = FolderOfThisProgram();
  if (!folder.empty() && std::filesystem::exists(folder / name)) return folder / name;
  const std::filesystem::path found = FindProgram(name);
  if (found.empty()) throw Error(name + ": no such program beside this one or on the PATH");
  return found;
}

}  // namespace colmap_ext
