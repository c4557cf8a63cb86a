// What a long-running stage may tell its caller, and how the caller stops it. Passed explicitly:
// there is no global logger.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace colmap_ext {

enum class LogLevel { kDebug = 0, kInfo = 1, kWarning = 2, kError = 3 };

// Receives messages and progress; implementations must be thread-safe.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  virtual void Message(LogLevel level, std::string_view text) = 0;
  // `done` of `total` units of `stage` are finished.
  virtual void Progress(std::string_view stage, std::size_t done, std::size_t total) = 0;
};

// Handed to every stage. A default-constructed one is silent and never cancelled (for tests).
class JobControl {
 public:
  JobControl() = default;
  // Neither pointer is owned; both may be null and must outlive this object.
  JobControl(ProgressSink* sink, const std::atomic<bool>* cancel) : sink_(sink), cancel_(cancel) {}

  void Debug(std::string_view text) const { Send(LogLevel::kDebug, text); }
  void Info(std::string_view text) const { Send(LogLevel::kInfo, text); }
  void Warn(std::string_view text) const { Send(LogLevel::kWarning, text); }
  void Progress(std::string_view stage, std::size_t done, std::size_t total) const {
    if (sink_ != nullptr) sink_->Progress(stage, done, total);
  }

  bool IsCancelled() const { return cancel_ != nullptr && cancel_->load(); }
  // Throws CancelledError when the user asked to stop. Call between units of work.
  void ThrowIfCancelled() const;

 private:
  void Send(LogLevel level, std::string_view text) const {
    if (sink_ != nullptr) sink_->Message(level, text);
  }

  ProgressSink* sink_ = nullptr;
  const std::atomic<bool>* cancel_ = nullptr;
};

// Parses "debug", "info", "warning" or "error"; throws UsageError otherwise.
LogLevel ParseLogLevel(const std::string& name);

// Prints messages to stderr, and progress as one line that is rewritten on a terminal, or as plain
// lines (first, every tenth, last) when stderr is not a terminal.
class ConsoleSink : public ProgressSink {
 public:
  explicit ConsoleSink(LogLevel min_level);
  ~ConsoleSink() override;
  ConsoleSink(const ConsoleSink&) = delete;
  ConsoleSink& operator=(const ConsoleSink&) = delete;
  void Message(LogLevel level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace colmap_ext
