// What every command does the same way: parse, help, logging.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

// Adds --log_level, parses, and answers -h. Use:
//   CommandLine line("view_planner", "What it does, in a sentence or two.");
//   line.options().Add("", "workspace_path", &workspace_path, "…");
//   BindOptions(line.options(), &nbv_options);
//   if (!line.Parse(arguments)) return 0;          // help was printed
//   ConsoleSink sink(line.log_level());
//   const JobControl job(&sink, &cancel);
class CommandLine {
 public:
  CommandLine(std::string name, std::string description);

  OptionSet& options() { return options_; }
  // Returns false when help was asked for (and printed). Throws UsageError for wrong usage.
  bool Parse(const std::vector<std::string>& arguments);
  LogLevel log_level() const;

 private:
  std::string name_;
  std::string description_;
  std::string log_level_name_ = "info";
  OptionSet options_;
};

// Throws UsageError "…: --name is required" when `value` is empty.
void RequireOption(const std::filesystem::path& value, const std::string& name);

}  // namespace colmap_ext
