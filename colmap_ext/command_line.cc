#include "command_line.h"

#include <iostream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

CommandLine::CommandLine(std::string name, std::string description)
    : name_(std::move(name)), description_(std::move(description)) {
  options_.Add("", "log_level", &log_level_name_, "debug, info, warning or error");
}

bool CommandLine::Parse(const std::vector<std::string>& arguments) {
  options_.Parse(arguments);
  if (options_.HelpRequested()) {
    std::cout << "colmap_ext " << name_ << "\n\n"
              << description_ << "\n\n"
              << options_.HelpText() << "\nExit codes: 0 done, 1 failed, 2 wrong usage.\n";
    return false;
  }
  ParseLogLevel(log_level_name_);
  return true;
}

LogLevel CommandLine::log_level() const { return ParseLogLevel(log_level_name_); }

void RequireOption(const std::filesystem::path& value, const std::string& name) {
  if (value.empty()) throw UsageError("--" + name + " is required; -h lists all options");
}

}  // namespace colmap_ext
