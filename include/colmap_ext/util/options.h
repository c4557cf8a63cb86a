// One table of options serves the command line, INI files, help texts and session.ini.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace colmap_ext {

// Options of one command, in COLMAP's style: `--workspace_path W --Section.name value`, and the
// same names in an INI file (`[Section]` then `name = value`). Stages declare theirs by a function
//   void BindOptions(OptionSet& set, FooOptions* options);
// which calls set.Add("Foo", "name", &options->name, "meaning (unit, range)") for each field; the
// value already in the field is the default.
class OptionSet {
 public:
  OptionSet();
  ~OptionSet();
  OptionSet(const OptionSet&) = delete;
  OptionSet& operator=(const OptionSet&) = delete;

  // Supported T: bool (0/1), int, double, std::string, std::filesystem::path, std::uint64_t.
  // `section` may be empty (plain `--name`). `value` must outlive this object.
  template <typename T>
  void Add(const std::string& section, const std::string& name, T* value, const std::string& help);

  // Parses `arguments` (without program and command name) and, when `--project_path F` is among
  // them, the INI file F first (the command line wins). Throws UsageError naming the wrong option,
  // with the file and line for an INI file. Unknown options are errors on the command line; in an
  // INI file, unknown names inside a section that this set uses are errors, other sections are
  // ignored.
  void Parse(const std::vector<std::string>& arguments);

  // Reads an INI file as above (also used for a workspace's session.ini). Values that the command
  // line gave are kept.
  void ParseIniFile(const std::filesystem::path& path);

  // Whether the user gave this option ("Section.name" or "name") on the command line or by INI.
  bool IsSet(const std::string& full_name) const;
  bool HelpRequested() const;  // -h or --help

  std::string HelpText() const;  // every option with its default
  std::string ToIni() const;     // every sectioned option with its present value

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
