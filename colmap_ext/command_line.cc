#include "command_line.h"

#include <iostream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"
#include "manual.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kTextWidth = 96;  // that of the option table

// The option set knows of text and of its table only.
std::string HelpFormatIn(const std::vector<std::string>& arguments) {
  const std::string name = "--help_format";
  std::string format = "text";
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == name && i + 1 < arguments.size()) format = arguments[i + 1];
    if (arguments[i].starts_with(name + "=")) format = arguments[i].substr(name.size() + 1);
  }
  return format;
}

}  // namespace

CommandLine::CommandLine(std::string name, std::string description)
    : name_(std::move(name)), description_(std::move(description)) {
  options_.Add("", "log_level", &log_level_, "debug, info, warning or error");
  options_.Add("", "log_format", &log_format_,
               "text, or json: an object a line on stderr (docs/file_formats.md)");
}

bool CommandLine::Parse(const std::vector<std::string>& arguments, ProgramLog* log) {
  options_.Parse(arguments);
  if (options_.HelpRequested()) {
    PrintHelp(HelpFormatIn(arguments));
    return false;
  }
  log->Configure(log_format_, ParseLogLevel(log_level_));
  return true;
}

void CommandLine::PrintHelp(const std::string& format) const {
  const bool is_program = name_.starts_with("colmap_ext_");
  const std::string program = is_program ? name_ : "colmap_ext " + name_;
  if (format == "text") {
    std::cout << program << "\n\n"
              << WrapText(description_, kTextWidth) << "\n\n"
              << options_.HelpText() << "\nExit codes: " << kExitCodes << ".\n";
    return;
  }
  const std::string table = options_.HelpText();
  const CommandManual manual{program, description_, actions_, nlohmann::ordered_json::parse(table)};
  if (format == "json") {
    std::cout << table;
  } else if (format == "man") {
    std::cout << ManualPage(manual);
  } else if (format == "completion") {
    std::cout << CompletionTable(manual);
    if (is_program) std::cout << CompletionFunction(name_, {});
  } else {
    throw UsageError("--help_format " + format + ": must be text, json, man or completion");
  }
}

void RequireOption(const std::filesystem::path& value, const std::string& name) {
  if (value.empty()) throw UsageError("--" + name + " is required; -h lists all options");
}

}  // namespace colmap_ext
