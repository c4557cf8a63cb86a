// What a program says while it runs.
#pragma once

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/json_sink.h"

namespace colmap_ext {

// On stderr: lines for people (--log_format text), or one JSON object a line for programs
// (--log_format json; docs/file_formats.md, "The log as JSON"). Events are for programs only;
// people read the same on stdout and in messages.
class ProgramLog : public ProgressSink {
 public:
  using Json = nlohmann::ordered_json;

  // `name`: "colmap_ext view_planner". Until Configure() is called, the format is what `arguments`
  // ask for, so that a mistake in them is told in that format, too.
  ProgramLog(std::string name, const std::vector<std::string>& arguments);

  // Throws UsageError for another format than text or json.
  void Configure(const std::string& format, LogLevel min_level);

  void Message(LogLevel level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;

  void Event(std::string_view event, const Json& fields);
  void Start(const std::string& version, const std::vector<std::string>& arguments);
  // What the program found or made: numbers, and paths of what it wrote.
  void Result(const Json& fields) { Event("result", fields); }
  // Why the program fails: one line. `kind`: "usage", "failed", "stopped" or "memory".
  void Fail(std::string_view kind, std::string_view message);
  // The last word.
  void End(int exit_code);

 private:
  std::string name_;
  std::unique_ptr<ProgressSink> sink_;
  JsonSink* json_ = nullptr;  // sink_ when that is one
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace colmap_ext
