#include "manual.h"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

namespace colmap_ext {
namespace {

using Json = nlohmann::ordered_json;

// Text that roff prints as it is.
std::string Roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else if (c == '\'') {
      escaped += "\\(aq";
    } else {
      escaped += c;
    }
  }
  return escaped.starts_with('.') ? "\\&" + escaped : escaped;
}

std::string WithDashes(std::string program) {
  std::replace(program.begin(), program.end(), ' ', '-');
  return program;
}

// The first sentence, as a line of whatis(1).
std::string SummaryOf(const std::string& description) {
  std::string summary = description.substr(0, description.find(". "));
  while (summary.ends_with('.')) summary.pop_back();
  summary = summary.substr(0, summary.find(": "));
  summary[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(summary[0])));
  return summary;
}

std::string Head(const std::string& page, const std::string& summary) {
  return ".TH " + Roff(page) + " 1 \"\" \"colmap_ext " COLMAP_EXT_VERSION "\" \"colmap_ext\"\n" +
         ".SH NAME\n" + Roff(page) + " \\- " + Roff(summary) + "\n";
}

std::string Tail(const std::string& see_also) {
  return std::string(".SH EXIT STATUS\n") + kExitCodes + ".\n.SH SEE ALSO\n" + see_also +
         ".PP\nThe documents that are installed with the programs, share/doc/colmap_ext/: "
         "file_formats.md, algorithms.md, flying.md.\n";
}

std::string Reference(const std::string& page) { return ".BR " + Roff(page) + " (1)"; }

std::string OptionEntry(const Json& option) {
  const std::string name = option["name"], type = option["type"], help = option["help"];
  const std::string default_text = option["default"];
  std::string entry = ".TP\n\\fB\\-\\-" + Roff(name) + "\\fR";
  if (name == "help") entry = ".TP\n\\fB\\-h\\fR, \\fB\\-\\-help\\fR";
  if (!type.empty()) entry += " \\fI" + Roff(type) + "\\fR";
  entry += "\n" + Roff(help);
  if (!default_text.empty()) entry += ".\nDefault: " + Roff(default_text);
  return entry + "\n";
}

std::string OptionSections(const Json& options) {
  std::string text = ".SH OPTIONS\n";
  std::vector<std::string> sections;
  for (const Json& option : options) {
    const std::string section = option["section"];
    if (section.empty()) text += OptionEntry(option);
    if (!section.empty() && std::find(sections.begin(), sections.end(), section) == sections.end())
      sections.push_back(section);
  }
  for (const std::string& section : sections) {
    text += ".SS " + Roff(section) + "\n";
    for (const Json& option : options) {
      if (option["section"] == section) text += OptionEntry(option);
    }
  }
  return text;
}

std::string Joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// What a table knows of an option's values.
std::string ValuesOf(const Json& option) {
  const std::string type = option["type"];
  if (type.empty()) return "none";
  if (type == "a path") return "path";
  if (type == "0 or 1") return "words 0 1";
  if (type != "text") return "words";
  return "words " + Joined(ChoicesIn(option["help"]), " ");
}

constexpr const char* kCompletionFunction = R"(_PROGRAM() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]}
  local verb=PROGRAM verbs='VERBS' first=1 table option kind values words=
  [[ $cur == = ]] && cur=
  [[ $prev == = ]] && prev=${COMP_WORDS[COMP_CWORD-2]}
  if [[ -n $verbs ]]; then
    if ((COMP_CWORD == 1)); then
      mapfile -t COMPREPLY < <(compgen -W "$verbs help version" -- "$cur")
      return
    fi
    verb=${COMP_WORDS[1]} first=2
    if [[ $verb == help ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$verbs --format" -- "$cur")
      return
    fi
  fi
  [[ $verb =~ ^[a-z_]+$ ]] || return
  table=_PROGRAM_table_$verb
  while read -r option kind values; do
    if [[ $kind == actions ]]; then
      ((COMP_CWORD == first)) && words+=" $values"
    elif [[ $option == "$prev" && $kind == path ]]; then
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -f -- "$cur")
      return
    elif [[ $option == "$prev" && $kind == words ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$values" -- "$cur")
      return
    else
      words+=" $option"
    fi
  done <<< "${!table}"
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
}
complete -F _PROGRAM PROGRAM
)";

}  // namespace

std::string ManualPage(const CommandManual& manual) {
  std::string page = Head(WithDashes(manual.program), SummaryOf(manual.description));
  page += ".SH SYNOPSIS\n.B " + Roff(manual.program) + "\n";
  if (!manual.actions.empty()) page += Roff(Joined(manual.actions, " | ")) + "\n";
  page += "[\\fB\\-\\-\\fIoption value\\fR] [\\fB\\-\\-\\fISection.option value\\fR]\n";
  page += ".SH DESCRIPTION\n" + Roff(manual.description) + "\n";
  page += OptionSections(manual.options);
  return page + Tail(Reference("colmap_ext") + "\n");
}

std::string ManualPageOfColmapExt(const std::vector<CommandSummary>& commands) {
  std::string page = Head("colmap_ext", "active image-based modeling for COLMAP");
  page +=
      ".SH SYNOPSIS\n.B colmap_ext\n\\fIcommand\\fR [\\fB\\-\\-\\fIoption value\\fR] "
      "[\\fB\\-\\-\\fISection.option value\\fR]\n.br\n.B colmap_ext help\n[\\fIcommand\\fR]\n";
  page +=
      ".SH DESCRIPTION\nPhotos in, next best views out, until the model is covered. Every command "
      "takes either a folder of a session (\\-\\-workspace_path) or explicit paths in COLMAP\\(aqs "
      "names, and an INI file of options (\\-\\-project_path), over which the command line wins.\n";
  page += ".SH COMMANDS\n";
  std::string references;
  for (const CommandSummary& command : commands) {
    page += ".TP\n.B " + Roff(command.name) + "\n" + Roff(command.summary) + "\n";
    references += Reference("colmap_ext-" + command.name) + ",\n";
  }
  page +=
      ".SH ENVIRONMENT\n.TP\n.B PATH\nwhere the colmap program is looked for (or "
      "\\-\\-colmap_path), and, for dense_reconstructor, OpenMVS\n";
  page +=
      ".SH FILES\n.TP\n.I workspace/session.ini\noptions of a session; later commands in its "
      "workspace read them\n.TP\n.I workspace/iterations/NNN/\nresults of an iteration\n.TP\n.I "
      "workspace/report/index.html\nthe page of the session\n";
  return page + Tail(references + Reference("colmap_ext_flightd") + ",\n" +
                     Reference("colmap_ext_dronesim") + "\n");
}

std::vector<std::string> ChoicesIn(const std::string& help) {
  static const std::regex parenthesis(R"( ?\([^)]*\))");
  static const std::regex list("[a-z0-9][a-z0-9_-]*(, [a-z0-9][a-z0-9_-]*)*,? or [a-z0-9_-]+");
  static const std::regex word("[a-z0-9][a-z0-9_-]*");
  std::string text = std::regex_replace(help, parenthesis, "");
  text = Replaced(Replaced(text, ": ", "\n"), "; ", "\n");
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part);) {
    if (!std::regex_match(part, list)) continue;
    std::vector<std::string> choices;
    for (std::sregex_iterator it(part.begin(), part.end(), word), end; it != end; ++it) {
      if (it->str() != "or") choices.push_back(it->str());
    }
    return choices;
  }
  return {};
}

std::string CompletionTable(const CommandManual& manual) {
  const std::size_t space = manual.program.find(' ');
  const std::string program = manual.program.substr(0, space);
  const std::string verb = space == std::string::npos ? program : manual.program.substr(space + 1);
  std::string table = "_" + program + "_table_" + verb + "='";
  if (!manual.actions.empty()) table += "- actions " + Joined(manual.actions, " ") + "\n";
  for (const Json& option : manual.options) {
    table += "--" + option["name"].get<std::string>() + " " + ValuesOf(option) + "\n";
  }
  table.pop_back();
  return table + "'\n";
}

std::string CompletionFunction(const std::string& program,
                               const std::vector<std::string>& commands) {
  return Replaced(Replaced(kCompletionFunction, "PROGRAM", program), "VERBS",
                  Joined(commands, " "));
}

}  // namespace colmap_ext
