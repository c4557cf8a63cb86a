#include "colmap_ext/util/json_sink.h"

#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "colmap_ext/util/utc_time.h"

namespace colmap_ext {
namespace {

using JsonLine = nlohmann::ordered_json;

const char* NameOf(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return "debug";
    case LogLevel::kInfo:
      return "info";
    case LogLevel::kWarning:
      return "warning";
    case LogLevel::kError:
      return "error";
  }
  return "error";
}

void PrintLine(const JsonLine& line) {
  const std::string text = line.dump(-1, ' ', false, JsonLine::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

struct JsonSink::State {
  std::mutex mutex;
  LogLevel min_level = LogLevel::kInfo;
  std::string stage;           // of the last progress
  std::size_t last_tenth = 0;  // of the last line of progress
};

JsonSink::JsonSink(LogLevel min_level) : state_(std::make_unique<State>()) {
  state_->min_level = min_level;
}

JsonSink::~JsonSink() = default;

void JsonSink::Message(LogLevel level, std::string_view text) {
  if (level < state_->min_level) return;
  const std::lock_guard lock(state_->mutex);
  PrintLine(
      {{"time", UtcNow()}, {"event", "message"}, {"level", NameOf(level)}, {"message", text}});
}

void JsonSink::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  if (LogLevel::kInfo < state_->min_level) return;
  const std::lock_guard lock(state_->mutex);
  const std::size_t tenth = total == 0 ? 10 : done * 10 / total;
  const bool is_new = state_->stage != stage || tenth < state_->last_tenth;
  if (!is_new && tenth == state_->last_tenth) return;
  state_->stage = stage;
  state_->last_tenth = tenth;
  PrintLine({{"time", UtcNow()},
             {"event", "progress"},
             {"stage", stage},
             {"done", done},
             {"total", total}});
}

void JsonSink::Event(std::string_view name, const nlohmann::ordered_json& fields) {
  JsonLine line = {{"time", UtcNow()}, {"event", name}};
  if (!fields.is_null()) line.update(fields);
  const std::lock_guard lock(state_->mutex);
  PrintLine(line);
}

}  // namespace colmap_ext
