#include "program_log.h"

#include <unistd.h>

#include <iostream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

bool AsksForJson(const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--log_format=json") return true;
    if (arguments[i] == "--log_format" && i + 1 < arguments.size() && arguments[i + 1] == "json") {
      return true;
    }
  }
  return false;
}

}  // namespace

ProgramLog::ProgramLog(std::string name, const std::vector<std::string>& arguments)
    : name_(std::move(name)) {
  Configure(AsksForJson(arguments) ? "json" : "text", LogLevel::kInfo);
}

void ProgramLog::Configure(const std::string& format, LogLevel min_level) {
  json_ = nullptr;
  if (format == "json") {
    auto sink = std::make_unique<JsonSink>(min_level);
    json_ = sink.get();
    sink_ = std::move(sink);
  } else if (format == "text") {
    sink_ = std::make_unique<ConsoleSink>(min_level);
  } else {
    throw UsageError("--log_format " + format + ": must be text or json");
  }
}

void ProgramLog::Message(LogLevel level, std::string_view text) { sink_->Message(level, text); }

void ProgramLog::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  sink_->Progress(stage, done, total);
}

void ProgramLog::Event(std::string_view event, const Json& fields) {
  if (json_ != nullptr) json_->Event(event, fields);
}

void ProgramLog::Start(const std::string& version, const std::vector<std::string>& arguments) {
  Event("start",
        {{"program", name_}, {"version", version}, {"pid", getpid()}, {"arguments", arguments}});
}

void ProgramLog::Fail(std::string_view kind, std::string_view message) {
  if (json_ != nullptr) {
    Event("error", {{"kind", kind}, {"message", message}});
  } else {
    std::cerr << name_ << ": " << message << '\n';
  }
}

void ProgramLog::End(int exit_code) {
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  Event("end", {{"exit_code", exit_code}, {"wall_s", wall.count()}});
}

}  // namespace colmap_ext
