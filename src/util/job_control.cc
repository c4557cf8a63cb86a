#include "colmap_ext/util/job_control.h"

#include <unistd.h>

#include <cstdio>
#include <mutex>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

void JobControl::ThrowIfCancelled() const {
  if (IsCancelled()) throw CancelledError();
}

LogLevel ParseLogLevel(const std::string& name) {
  if (name == "debug") return LogLevel::kDebug;
  if (name == "info") return LogLevel::kInfo;
  if (name == "warning") return LogLevel::kWarning;
  if (name == "error") return LogLevel::kError;
  throw UsageError("--log_level " + name + ": must be debug, info, warning or error");
}

struct ConsoleSink::State {
  std::mutex mutex;
  LogLevel min_level = LogLevel::kInfo;
  bool is_terminal = false;
  bool line_is_open = false;   // a progress line without its newline stands on the terminal
  std::string stage;           // of the last progress
  std::size_t last_tenth = 0;  // of the last plain progress line

  void CloseLine() {
    if (line_is_open) std::fputc('\n', stderr);
    line_is_open = false;
  }

  void ShowOnTerminal(std::string_view name, std::size_t done, std::size_t total) {
    if (line_is_open && stage != name) CloseLine();
    std::fprintf(stderr, "\r\033[K  %.*s %zu/%zu", static_cast<int>(name.size()), name.data(), done,
                 total);
    line_is_open = true;
    if (done >= total) CloseLine();
    std::fflush(stderr);
  }

  void ShowAsLines(std::string_view name, std::size_t done, std::size_t total) {
    const std::size_t tenth = total == 0 ? 10 : done * 10 / total;
    const bool is_new = stage != name || tenth < last_tenth;
    if (!is_new && tenth == last_tenth) return;
    last_tenth = tenth;
    std::fprintf(stderr, "  %.*s %zu/%zu\n", static_cast<int>(name.size()), name.data(), done,
                 total);
  }
};

ConsoleSink::ConsoleSink(LogLevel min_level) : state_(std::make_unique<State>()) {
  state_->min_level = min_level;
  state_->is_terminal = isatty(STDERR_FILENO) != 0;
}

ConsoleSink::~ConsoleSink() { state_->CloseLine(); }

void ConsoleSink::Message(LogLevel level, std::string_view text) {
  if (level < state_->min_level) return;
  const std::lock_guard lock(state_->mutex);
  state_->CloseLine();
  const char* prefix = level == LogLevel::kWarning ? "warning: "
                       : level == LogLevel::kError ? "error: "
                                                   : "";
  std::fprintf(stderr, "%s%.*s\n", prefix, static_cast<int>(text.size()), text.data());
}

void ConsoleSink::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  if (LogLevel::kInfo < state_->min_level) return;
  const std::lock_guard lock(state_->mutex);
  if (state_->is_terminal) {
    state_->ShowOnTerminal(stage, done, total);
  } else {
    state_->ShowAsLines(stage, done, total);
  }
  state_->stage = stage;
}

}  // namespace colmap_ext
