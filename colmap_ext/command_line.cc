#include "command_line.h"

#include <iostream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

CommandLine::CommandLine(std::string name, std::string description)
    : name_(std::move(name)), description_(std::move(description)) {
  options_.Add("", "log_level", &log_level_, "debug, info, warning or error");
  options_.Add("", "log_format", &log_format_,
               "text, or json: an object a line on stderr (docs/file_formats.md)");
}

bool CommandLine::Parse(const std::vector<std::string>& arguments, ProgramLog* log) {
  options_.Parse(arguments);
  if (options_.HelpRequested()) {
    const std::string title = name_.starts_with("colmap_ext_") ? name_ : "colmap_ext " + name_;
    std::cout << title << "\n\n"
              << description_ << "\n\n"
              << options_.HelpText() << "\nExit codes: 0 done, 1 failed, 2 wrong usage.\n";
    return false;
  }
  log->Configure(log_format_, ParseLogLevel(log_level_));
  return true;
}

void RequireOption(const std::filesystem::path& value, const std::string& name) {
  if (value.empty()) throw UsageError("--" + name + " is required; -h lists all options");
}

}  // namespace colmap_ext
