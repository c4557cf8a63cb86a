// Help in the formats that other programs read: manual pages and bash completion. All of it comes
// from the table of options that -h prints.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace colmap_ext {

inline constexpr const char* kExitCodes = "0 done, 1 failed, 2 wrong usage";

// What is known of a command or a program of its own.
struct CommandManual {
  std::string program;               // "colmap_ext view_planner", "colmap_ext_flightd"
  std::string description;           // sentences; the first one is the summary
  std::vector<std::string> actions;  // words of which one comes before the options; may be empty
  nlohmann::ordered_json options;    // [{"name", "section", "type", "default", "help"}]
};

struct CommandSummary {
  std::string name;     // "view_planner"
  std::string summary;  // one line
};

// roff, macros of man(7), section 1.
std::string ManualPage(const CommandManual& manual);
std::string ManualPageOfColmapExt(const std::vector<CommandSummary>& commands);

// The words that `help` names as the values of an option: "church", "boxes", "gate" of "simulate
// this scene: church, boxes or gate". Empty when it names none.
std::vector<std::string> ChoicesIn(const std::string& help);

// A bash script is the tables of its commands, then the function that looks words up in them.
std::string CompletionTable(const CommandManual& manual);
// `commands`: the verbs; empty for a program of its own, whose only table is its own.
std::string CompletionFunction(const std::string& program,
                               const std::vector<std::string>& commands);

}  // namespace colmap_ext
