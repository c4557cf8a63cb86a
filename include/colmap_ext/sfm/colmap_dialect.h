// What the `colmap` program in use can do, and how its version spells it. Every difference between
// COLMAP 3.8 and 4.x that concerns the command line is in this file's .cc and nowhere else.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace colmap_ext {

// Options in COLMAP 3.8's spelling, without the leading "--", with their values.
using ColmapOptions = std::vector<std::pair<std::string, std::string>>;

// Asks a program about itself through its own help texts, each once.
class ColmapDialect {
 public:
  // Text of `colmap help` for "help", of `colmap <command> -h` for a command.
  using HelpSource = std::function<std::string(const std::string& command)>;

  // Throws Error when the text of `colmap help` is not COLMAP's.
  explicit ColmapDialect(HelpSource help_source);

  const std::string& help() const { return help_; }        // text of `colmap help`
  const std::string& version() const { return version_; }  // "3.8", "4.2.1"
  bool HasCommand(const std::string& command) const;
  // `option` in 3.8's spelling.
  bool HasOption(const std::string& command, const std::string& option);

  // Arguments "--name value …" for `command` in the program's own spelling. An option that this
  // version does not have is left out when it only tunes, and is an Error when the result would
  // depend on it. Throws Error when the program has no such command.
  std::vector<std::string> Arguments(const std::string& command, const ColmapOptions& options);

 private:
  const std::set<std::string>& OptionsOf(const std::string& command);
  std::string SpellingOf(const std::string& command, const std::string& option);

  HelpSource help_source_;
  std::string help_;
  std::string version_;
  std::set<std::string> commands_;
  std::map<std::string, std::set<std::string>> options_of_command_;
};

}  // namespace colmap_ext
