// Manual pages and bash completion, made from the options that -h prints.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {
namespace {

using nlohmann::json;

class Manual : public ProgramTest {
 protected:
  std::vector<std::string> Verbs() const {
    return Lines(Run({"help", "--format", "names"}).output);
  }

  static std::vector<std::string> Lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  // "--NextBestView.num_views", … as -h prints them.
  std::vector<std::string> OptionsOf(const std::string& verb) const {
    const std::string help = Run({verb, "-h"}).output;
    const std::regex option(R"(\n  (?:-h \[ )?(--[A-Za-z_.0-9]+))");
    std::vector<std::string> names;
    for (std::sregex_iterator it(help.begin(), help.end(), option), end; it != end; ++it) {
      names.push_back((*it)[1]);
    }
    return names;
  }

  static ChildProcessResult RunOther(std::vector<std::string> arguments) {
    ChildProcessOptions options;
    options.arguments = std::move(arguments);
    options.environment = {{"LC_ALL", "C.UTF-8"}, {"MANPAGER", "cat"}, {"MANWIDTH", "120"}};
    return RunChildProcess(options, JobControl());
  }

  // What bash offers for the last of `words`.
  std::vector<std::string> Complete(const std::vector<std::string>& words) const {
    if (!std::filesystem::exists(folder_ / "completion")) {
      WriteFileAtomically(folder_ / "completion", Run({"help", "--format", "completion"}).output);
    }
    std::vector<std::string> arguments = {
        "bash",
        "-c",
        "source \"$1\"; shift; COMP_WORDS=(\"$@\"); COMP_CWORD=$((${#COMP_WORDS[@]}-1)); "
        "_colmap_ext; printf '%s\\n' \"${COMPREPLY[@]}\"",
        "bash",
        (folder_ / "completion").string(),
        "colmap_ext"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const ChildProcessResult result = RunOther(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return Lines(result.output);
  }
};

std::string WithoutHyphenEscapes(std::string page) {
  return std::regex_replace(page, std::regex(R"(\\-)"), "-");
}

TEST_F(Manual, EveryCommandHasAPageWithEveryOption) {
  const std::vector<std::string> verbs = Verbs();
  ASSERT_GE(verbs.size(), 15u);
  const std::string main_page = WithoutHyphenEscapes(Run({"help", "--format", "man"}).output);
  for (const std::string& verb : verbs) {
    EXPECT_NE(main_page.find(verb), std::string::npos) << verb;
    const std::string page = WithoutHyphenEscapes(Run({"help", verb, "--format", "man"}).output);
    EXPECT_TRUE(page.starts_with(".TH colmap_ext-" + verb)) << page.substr(0, 60);
    const std::vector<std::string> options = OptionsOf(verb);
    EXPECT_GE(options.size(), 5u) << verb;
    for (const std::string& option : options) {
      EXPECT_NE(page.find(option + "\\fR"), std::string::npos) << verb << " " << option;
    }
  }
}

TEST_F(Manual, PagesAreCleanRoff) {
  if (FindProgram("man").empty()) GTEST_SKIP() << "no man";
  std::vector<std::string> names = Verbs();
  names.emplace_back("");
  for (const std::string& name : names) {
    std::vector<std::string> arguments = {"help", "--format", "man"};
    if (!name.empty()) arguments.push_back(name);
    const std::filesystem::path page = folder_ / ("page" + name + ".1");
    WriteFileAtomically(page, Run(arguments).output);
    const ChildProcessResult shown = RunOther({"man", "--warnings", "-l", page.string()});
    EXPECT_EQ(shown.exit_code, 0) << name;
    EXPECT_EQ(shown.output.find("warning:"), std::string::npos) << name << ": " << shown.output;
    EXPECT_NE(shown.output.find("EXIT STATUS"), std::string::npos) << name;
  }
}

TEST_F(Manual, TheTableOfOptionsAsJson) {
  const json table = json::parse(Run({"view_planner", "--help_format", "json"}).output);
  bool found = false;
  for (const json& option : table) {
    if (option["name"] != "NextBestView.strategy") continue;
    found = true;
    EXPECT_EQ(option["section"], "NextBestView");
    EXPECT_EQ(option["type"], "text");
    EXPECT_EQ(option["default"], "submodular");
  }
  EXPECT_TRUE(found);
  ExpectFailure(Run({"view_planner", "--help_format", "html"}), 2, {"html", "completion"});
  ExpectFailure(Run({"help", "fly_away"}), 2, {"no such command", "fly_away"});
}

TEST_F(Manual, BashCompletes) {
  if (FindProgram("bash").empty()) GTEST_SKIP() << "no bash";
  using Words = std::vector<std::string>;
  EXPECT_EQ(Complete({"vi"}), Words{"view_planner"});
  EXPECT_EQ(Complete({"help", "super"}), (Words{"superpixel_segmenter", "superpixel_stereo"}));
  EXPECT_EQ(Complete({"active_capture", "--scene", "ch"}), Words{"church"});
  EXPECT_EQ(Complete({"active_capture", "--scene", "=", "bo"}), Words{"boxes"});
  EXPECT_EQ(Complete({"active_capture", "--log_format", ""}), (Words{"text", "json"}));
  EXPECT_EQ(Complete({"flight_client", "ab"}), Words{"abort"});
  EXPECT_EQ(Complete({"no_such_command", "--x"}), Words{""});
  std::filesystem::create_directories(folder_ / "some folder");
  EXPECT_EQ(Complete({"view_planner", "--workspace_path", (folder_ / "so").string()}),
            Words{(folder_ / "some folder").string()});
}

TEST_F(Manual, CompletionOffersEveryOption) {
  if (FindProgram("bash").empty()) GTEST_SKIP() << "no bash";
  for (const char* verb : {"active_capture", "path_planner", "mission_exporter"}) {
    EXPECT_EQ(Complete({verb, "--"}).size(), OptionsOf(verb).size()) << verb;
  }
}

}  // namespace
}  // namespace colmap_ext
