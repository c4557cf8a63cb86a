#include "colmap_ext/util/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "colmap_ext/util/error.h"
#include "util/seconds_of.h"

extern char** environ;

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxKeptOutput = std::size_t{1} << 20;

std::vector<std::string> MergedEnvironment(const std::map<std::string, std::string>& added) {
  std::vector<std::string> merged;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (!added.contains(text.substr(0, text.find('=')))) merged.push_back(text);
  }
  for (const auto& [name, value] : added) merged.push_back(name + "=" + value);
  return merged;
}

std::vector<char*> PointersTo(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& text : strings) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Only async-signal-safe calls between fork and exec.
[[noreturn]] void ExecuteInChild(const char* program, char* const* arguments,
                                 char* const* environment, bool fixed_addresses, int output,
                                 pid_t parent) {
  setpgid(0, 0);  // Ctrl-C reaches us, and we stop the child in our own time
  sigset_t no_signals;
  sigemptyset(&no_signals);
  sigprocmask(SIG_SETMASK, &no_signals, nullptr);  // ours blocks the signals it waits for
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (fixed_addresses) personality(ADDR_NO_RANDOMIZE);
  if (getppid() != parent) _exit(127);
  const int null_input = open("/dev/null", O_RDONLY);
  dup2(null_input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execve(program, arguments, environment);
  _exit(127);
}

// Collects the child's output until it closes the pipe; kills it when the job is cancelled.
class OutputCollector {
 public:
  OutputCollector(int pipe, const fs::path& log_path) : pipe_(pipe) {
    if (log_path.empty()) return;
    std::error_code ignored;
    fs::create_directories(log_path.parent_path(), ignored);
    log_.open(log_path, std::ios::binary | std::ios::app);
    if (!log_) throw Error(log_path.string() + ": cannot write the log file");
  }

  void Run(pid_t child, const JobControl& job) {
    bool is_open = true;
    while (is_open) {
      pollfd waiting{pipe_, POLLIN, 0};
      const int ready = poll(&waiting, 1, 100);
      if (job.IsCancelled()) kill(-child, SIGKILL);
      if (ready > 0) is_open = ReadOnce();
    }
  }

  std::string TakeOutput() { return std::move(kept_); }

 private:
  bool ReadOnce() {
    char buffer[65536];
    const ssize_t count = read(pipe_, buffer, sizeof buffer);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) return true;
    if (count <= 0) return false;
    if (log_.is_open()) log_.write(buffer, count).flush();
    kept_.append(buffer, static_cast<std::size_t>(count));
    if (kept_.size() > 2 * kMaxKeptOutput) kept_.erase(0, kept_.size() - kMaxKeptOutput);
    return true;
  }

  int pipe_;
  std::ofstream log_;
  std::string kept_;
};

void WaitForChild(pid_t child, ChildProcessResult* result) {
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  result->exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result->cpu_s = SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
  result->peak_mib = static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

fs::path FindProgram(const std::string& program) {
  const auto is_executable = [](const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored) && access(path.c_str(), X_OK) == 0;
  };
  if (program.find('/') != std::string::npos) {
    return is_executable(program) ? fs::path(program) : fs::path();
  }
  const char* search_path = std::getenv("PATH");
  std::istringstream folders(search_path == nullptr ? "" : search_path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    fs::path candidate = fs::path(folder.empty() ? "." : folder) / program;
    if (is_executable(candidate)) return candidate;
  }
  return {};
}

fs::path FolderOfThisProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

ChildProcessResult RunChildProcess(const ChildProcessOptions& options, const JobControl& job) {
  if (options.arguments.empty()) throw Error("no program to run was given");
  const fs::path program = FindProgram(options.arguments[0]);
  if (program.empty()) throw Error(options.arguments[0] + ": no such program on the PATH");

  std::vector<std::string> arguments = options.arguments;
  std::vector<std::string> environment = MergedEnvironment(options.environment);
  const std::vector<char*> argument_pointers = PointersTo(arguments);
  const std::vector<char*> environment_pointers = PointersTo(environment);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Error(program.string() + ": cannot make a pipe");
  const auto start = std::chrono::steady_clock::now();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw Error(program.string() + ": cannot start: " + std::strerror(errno));
  if (child == 0) {
    ExecuteInChild(program.c_str(), argument_pointers.data(), environment_pointers.data(),
                   options.fixed_addresses, ends[1], parent);
  }
  close(ends[1]);
  ChildProcessResult result;
  try {
    OutputCollector collector(ends[0], options.log_path);
    collector.Run(child, job);
    result.output = collector.TakeOutput();
  } catch (...) {
    kill(-child, SIGKILL);
    WaitForChild(child, &result);
    close(ends[0]);
    throw;
  }
  close(ends[0]);
  WaitForChild(child, &result);
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  job.ThrowIfCancelled();
  return result;
}

}  // namespace colmap_ext
