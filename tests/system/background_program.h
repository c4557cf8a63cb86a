// A program that a test watches, and kills.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "colmap_ext/util/files.h"

namespace colmap_ext {

class BackgroundProgram {
 public:
  // Standard output and error go to `log_path`; `input` is what it reads.
  BackgroundProgram(std::vector<std::string> arguments, std::filesystem::path log_path,
                    const std::string& input = "")
      : log_path_(std::move(log_path)) {
    const std::filesystem::path input_path = log_path_.string() + ".in";
    WriteFileAtomically(input_path, input);
    WriteFileAtomically(log_path_, "");
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int log = open(log_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(open(input_path.c_str(), O_RDONLY), STDIN_FILENO);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  ~BackgroundProgram() { Kill(SIGKILL); }
  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram& operator=(const BackgroundProgram&) = delete;

  pid_t pid() const { return pid_; }
  std::string Output() const { return ReadFile(log_path_); }

  // Sends the signal, waits for the end, returns the exit code (128 + signal for a signal's).
  int Kill(int signal) {
    if (!exit_code_) kill(pid_, signal);
    return Wait();
  }
  int Wait() {
    if (!exit_code_) {
      int status = 0;
      waitpid(pid_, &status, 0);
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    return *exit_code_;
  }
  bool IsRunning() {
    int status = 0;
    if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    return !exit_code_;
  }
  // False: it ended, or `timeout_s` passed, before `is_there`.
  bool WaitUntil(const std::function<bool()>& is_there, double timeout_s) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
    while (!is_there()) {
      if (!IsRunning() || std::chrono::steady_clock::now() > end) return is_there();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

 private:
  std::filesystem::path log_path_;
  pid_t pid_ = 0;
  std::optional<int> exit_code_;
};

// Process ids of programs of this name that have `word` among their arguments, zombies left out.
inline std::vector<pid_t> FindProcesses(const std::string& program, const std::string& word) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stream(entry.path() / "cmdline", std::ios::binary);
    const std::string line((std::istreambuf_iterator<char>(stream)), {});
    const std::string path = line.substr(0, line.find('\0'));
    const bool is_it = std::filesystem::path(path).filename() == program;
    if (is_it && line.find(word) != std::string::npos) found.push_back(std::stoi(name));
  }
  return found;
}

}  // namespace colmap_ext
