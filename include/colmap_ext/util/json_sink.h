// Messages and progress for programs: one JSON object a line.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Writes to stderr, a line at a time, flushed:
//   {"time": "2026-05-04T10:11:12.345Z", "event": "message", "level": "info", "message": "…"}
//   {"time": …, "event": "progress", "stage": "depth maps", "done": 3, "total": 64}
// Text that is not UTF-8 has its wrong bytes replaced by U+FFFD. Progress is sent at every tenth,
// as the console's plain lines are.
class JsonSink : public ProgressSink {
 public:
  explicit JsonSink(LogLevel min_level);
  ~JsonSink() override;
  JsonSink(const JsonSink&) = delete;
  JsonSink& operator=(const JsonSink&) = delete;
  void Message(LogLevel level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  // A line of another kind, whatever the level: `fields` (an object, null for none) after time and
  // {"event": name}.
  void Event(std::string_view name, const nlohmann::ordered_json& fields);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace colmap_ext
