// What every command does the same way: parse, help, logging.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/util/options.h"
#include "program_log.h"

namespace colmap_ext {

// Adds --log_level and --log_format, parses, and answers -h. Use:
//   CommandLine line("view_planner", "What it does, in a sentence or two.");
//   line.options().Add("", "workspace_path", &workspace_path, "…");
//   BindOptions(line.options(), &nbv_options);
//   if (!line.Parse(arguments, &program.log)) return 0;  // help was printed
//   const JobControl job = program.Job();
class CommandLine {
 public:
  // `name`: of a verb of colmap_ext, or colmap_ext_… of a program of its own.
  CommandLine(std::string name, std::string description);

  OptionSet& options() { return options_; }
  // Words of which the user gives one before the options; the command itself takes them.
  void SetActions(std::vector<std::string> actions) { actions_ = std::move(actions); }
  // Sets up `log` as asked for. Returns false when help was asked for (and printed). Throws
  // UsageError for wrong usage.
  bool Parse(const std::vector<std::string>& arguments, ProgramLog* log);

 private:
  void PrintHelp(const std::string& format) const;

  std::string name_;
  std::string description_;
  std::vector<std::string> actions_;
  std::string log_level_ = "info";
  std::string log_format_ = "text";
  OptionSet options_;
};

// Throws UsageError "…: --name is required" when `value` is empty.
void RequireOption(const std::filesystem::path& value, const std::string& name);

}  // namespace colmap_ext
