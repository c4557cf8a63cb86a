#include "colmap_ext/util/options.h"

#include <array>
#include <boost/program_options.hpp>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

std::string ValueText(bool value) { return value ? "1" : "0"; }
std::string ValueText(const std::string& value) { return value; }
std::string ValueText(const fs::path& value) { return value.string(); }
// The shortest text that reads back as the same value.
template <typename T>
std::string ValueText(T value) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

template <typename T>
const char* TypeName();
template <>
const char* TypeName<bool>() {
  return "0 or 1";
}
template <>
const char* TypeName<int>() {
  return "a whole number";
}
template <>
const char* TypeName<std::uint64_t>() {
  return "a whole number >= 0";
}
template <>
const char* TypeName<double>() {
  return "a number";
}
template <>
const char* TypeName<std::string>() {
  return "text";
}
template <>
const char* TypeName<fs::path>() {
  return "a path";
}

void Assign(const std::string& text, std::string* value) { *value = text; }
void Assign(const std::string& text, fs::path* value) { *value = text; }
void Assign(const std::string& text, bool* value) {
  if (text == "1" || text == "true") {
    *value = true;
  } else if (text == "0" || text == "false") {
    *value = false;
  } else {
    throw std::invalid_argument(text);
  }
}
void Assign(const std::string& text, std::uint64_t* value) {
  std::size_t used = 0;
  if (text.empty() || text[0] == '-') throw std::invalid_argument(text);
  const std::uint64_t parsed = std::stoull(text, &used);
  if (used != text.size()) throw std::invalid_argument(text);
  *value = parsed;
}
void Assign(const std::string& text, int* value) {
  std::size_t used = 0;
  const int parsed = std::stoi(text, &used);
  if (used != text.size()) throw std::invalid_argument(text);
  *value = parsed;
}
void Assign(const std::string& text, double* value) {
  std::size_t used = 0;
  const double parsed = std::stod(text, &used);
  if (used != text.size()) throw std::invalid_argument(text);
  *value = parsed;
}

}  // namespace

namespace {

struct Option {
  std::string section;
  std::string name;
  std::string help;
  std::string type;
  std::string default_text;
  std::function<void(const std::string&)> assign;  // throws std::exception for a wrong value
  std::function<std::string()> present_text;

  std::string FullName() const { return section.empty() ? name : section + "." + name; }
};

}  // namespace

struct OptionSet::Impl {
  std::vector<Option> options;
  std::set<std::string> from_command_line;
  std::set<std::string> from_ini;
  bool help_requested = false;
  std::string help_format = "text";

  Option* Find(const std::string& full_name) {
    for (Option& option : options) {
      if (option.FullName() == full_name) return &option;
    }
    return nullptr;
  }

  std::string SuggestionFor(std::string name) const {
    name.erase(0, name.find_first_not_of('-'));
    std::vector<std::string> names;
    for (const Option& option : options) names.push_back(option.FullName());
    return Suggestion(name, names);
  }

  bool HasSection(const std::string& section) const {
    for (const Option& option : options) {
      if (option.section == section) return true;
    }
    return false;
  }

  po::options_description Description() const {
    po::options_description description("Options", 100, 50);
    for (const Option& option : options) {
      auto* semantic = po::value<std::string>();
      if (!option.default_text.empty()) semantic->default_value(option.default_text);
      semantic->value_name(option.type == std::string("0 or 1") ? "0|1" : "VALUE");
      description.add_options()(option.FullName().c_str(), semantic, option.help.c_str());
    }
    description.add_options()("project_path", po::value<std::string>()->value_name("FILE.ini"),
                              "read options from this file; the command line wins");
    description.add_options()("help,h", "this text");
    description.add_options()(
        "help_format", po::value<std::string>()->value_name("FORMAT"),
        "this text in another format: text, json, man (a page) or completion (bash)");
    return description;
  }

  // Every option as an object; for programs that make pages and completions of it.
  std::string DescriptionAsJson() const {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    const auto add = [&list](const std::string& name, const std::string& section,
                             const std::string& type, const std::string& default_text,
                             const std::string& help) {
      list.push_back({{"name", name},
                      {"section", section},
                      {"type", type},
                      {"default", default_text},
                      {"help", help}});
    };
    for (const Option& option : options) {
      add(option.FullName(), option.section, option.type, option.default_text, option.help);
    }
    const po::options_description all = Description();
    add("project_path", "", TypeName<fs::path>(), "",
        all.find("project_path", false).description());
    add("help", "", "", "", all.find("help", false).description());
    add("help_format", "", TypeName<std::string>(), "",
        all.find("help_format", false).description());
    return list.dump(2) + "\n";
  }

  // A yes-or-no option may stand alone: `--status` for `--status 1`.
  std::vector<std::string> WithFlagValues(const std::vector<std::string>& arguments) {
    std::vector<std::string> complete;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      complete.push_back(arguments[i]);
      if (!arguments[i].starts_with("--")) continue;
      const Option* option = Find(arguments[i].substr(2));
      const bool is_alone = i + 1 == arguments.size() || arguments[i + 1].starts_with("-");
      if (option != nullptr && option->type == TypeName<bool>() && is_alone) {
        complete.emplace_back("1");
      }
    }
    return complete;
  }

  void Set(Option& option, const std::string& text, const std::string& where) {
    try {
      option.assign(text);
    } catch (const std::exception&) {
      throw UsageError(where + ": '" + text + "' is not " + option.type);
    }
  }
};

OptionSet::OptionSet() : impl_(std::make_unique<Impl>()) {}
OptionSet::~OptionSet() = default;

template <typename T>
void OptionSet::Add(const std::string& section, const std::string& name, T* value,
                    const std::string& help) {
  Option option{section, name, help, TypeName<T>(), ValueText(*value), {}, {}};
  option.assign = [value](const std::string& text) { Assign(text, value); };
  option.present_text = [value] { return ValueText(*value); };
  if (impl_->Find(option.FullName()) != nullptr) {
    throw std::logic_error("option declared twice: " + option.FullName());
  }
  impl_->options.push_back(std::move(option));
}

template void OptionSet::Add(const std::string&, const std::string&, bool*, const std::string&);
template void OptionSet::Add(const std::string&, const std::string&, int*, const std::string&);
template void OptionSet::Add(const std::string&, const std::string&, double*, const std::string&);
template void OptionSet::Add(const std::string&, const std::string&, std::string*,
                             const std::string&);
template void OptionSet::Add(const std::string&, const std::string&, fs::path*, const std::string&);
template void OptionSet::Add(const std::string&, const std::string&, std::uint64_t*,
                             const std::string&);

void OptionSet::Parse(const std::vector<std::string>& given_arguments) {
  namespace style = po::command_line_style;
  const std::vector<std::string> arguments = impl_->WithFlagValues(given_arguments);
  fs::path project_path;
  try {
    const po::options_description description = impl_->Description();
    const po::parsed_options parsed =
        po::command_line_parser(arguments)
            .options(description)
            .style(style::allow_long | style::allow_short | style::allow_dash_for_short |
                   style::long_allow_adjacent | style::long_allow_next | style::short_allow_next)
            .positional(po::positional_options_description())
            .run();
    for (const po::option& given : parsed.options) {
      if (given.string_key == "help") {
        impl_->help_requested = true;
      } else if (given.string_key == "help_format") {
        impl_->help_requested = true;
        impl_->help_format = given.value.at(0);
      } else if (given.string_key == "project_path") {
        project_path = given.value.at(0);
      } else {
        impl_->Set(*impl_->Find(given.string_key), given.value.at(0), "--" + given.string_key);
        impl_->from_command_line.insert(given.string_key);
      }
    }
  } catch (const po::unknown_option& error) {
    throw UsageError(std::string(error.what()) + impl_->SuggestionFor(error.get_option_name()) +
                     "; -h lists all options");
  } catch (const po::error& error) {
    throw UsageError(std::string(error.what()) + "; -h lists all options");
  }
  if (!project_path.empty() && !impl_->help_requested) ParseIniFile(project_path);
}

void OptionSet::ParseIniFile(const fs::path& path) {
  std::istringstream lines(ReadFile(path));
  const auto trim = [](const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos) return std::string();
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
  };
  std::string section;
  int number = 0;
  for (std::string raw; std::getline(lines, raw);) {
    ++number;
    const std::string line = trim(raw);
    const std::string where = path.string() + ":" + std::to_string(number);
    if (line.empty() || line[0] == '#' || line[0] == ';') continue;
    if (line.front() == '[') {
      if (line.back() != ']') throw UsageError(where + ": a section is written [Name]");
      section = trim(line.substr(1, line.size() - 2));
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) throw UsageError(where + ": expected name = value");
    const std::string name = trim(line.substr(0, equals));
    const std::string full_name = section.empty() ? name : section + "." + name;
    Option* option = impl_->Find(full_name);
    if (option == nullptr) {
      if (!section.empty() && !impl_->HasSection(section)) continue;
      if (section.empty()) continue;
      throw UsageError(where + ": no such option: " + full_name + impl_->SuggestionFor(full_name));
    }
    if (impl_->from_command_line.contains(full_name)) continue;
    impl_->Set(*option, trim(line.substr(equals + 1)), where + ": " + full_name);
    impl_->from_ini.insert(full_name);
  }
}

bool OptionSet::IsSet(const std::string& full_name) const {
  return impl_->from_command_line.contains(full_name) || impl_->from_ini.contains(full_name);
}

bool OptionSet::HelpRequested() const { return impl_->help_requested; }

std::string OptionSet::HelpText() const {
  if (impl_->help_format != "text") return impl_->DescriptionAsJson();
  std::ostringstream text;
  text << impl_->Description();
  return text.str();
}

std::string OptionSet::ToIni() const {
  std::ostringstream text;
  std::string section;
  for (const Option& option : impl_->options) {
    if (option.section.empty()) continue;
    if (option.section != section) {
      text << (section.empty() ? "" : "\n") << '[' << option.section << "]\n";
      section = option.section;
    }
    text << option.name << " = " << option.present_text() << '\n';
  }
  return text.str();
}

}  // namespace colmap_ext
