// What the documents say of the code is there.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

namespace {
namespace fs = std::filesystem;

const fs::path kProjectRoot = COLMAP_EXT_SOURCE_DIR;

std::string ReadAll(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// All sources, with string literals that stand one after another joined.
std::string SourceText() {
  std::string text;
  for (const char* tree : {"src", "colmap_ext", "include"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kProjectRoot / tree)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".cc" && extension != ".h") continue;
      std::istringstream lines(ReadAll(entry.path()));
      for (std::string line; std::getline(lines, line);) {
        line.erase(0, line.find_first_not_of(' '));
        if (line.starts_with('"') && text.ends_with("\"")) {
          text.pop_back();
          line.erase(0, 1);
        } else {
          text += '\n';
        }
        text += line;
      }
    }
  }
  return text;
}

TEST(Docs, TroubleshootingQuotesMessagesOfTheCode) {
  const std::string sources = SourceText();
  const std::regex heading(R"(^### `(.*)`$)");
  std::ifstream page(kProjectRoot / "docs" / "troubleshooting.md");
  std::size_t messages = 0;
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, heading)) continue;
    ++messages;
    EXPECT_NE(sources.find(match[1].str()), std::string::npos) << line;
  }
  EXPECT_GT(messages, 30u);
}

TEST(Docs, LinksLeadSomewhere) {
  const std::regex link(R"(\]\(([^)#:]+)(#[^)]*)?\))");
  std::size_t links = 0;
  for (const fs::path& folder : {kProjectRoot, kProjectRoot / "docs"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() != ".md") continue;
      const std::string text = ReadAll(entry.path());
      for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it) {
        ++links;
        EXPECT_TRUE(fs::exists(folder / (*it)[1].str())) << entry.path() << ": " << (*it)[1];
      }
    }
  }
  EXPECT_GT(links, 10u);
}

TEST(Docs, ExamplesAreNumberedRunAndExplained) {
  const std::string runner = ReadAll(kProjectRoot / "examples" / "run_all.sh");
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kProjectRoot / "examples")) {
    const std::string name = entry.path().filename();
    if (!std::regex_match(name, std::regex(R"([0-9][0-9]_[a-z0-9_]+\.(sh|py))"))) continue;
    ++count;
    EXPECT_NE(ReadAll(entry.path()).find("examples/" + name), std::string::npos)
        << name << " does not say how it is called";
    EXPECT_NE((fs::status(entry.path()).permissions() & fs::perms::owner_exec), fs::perms::none)
        << name;
  }
  EXPECT_GE(count, 8);
  EXPECT_NE(runner.find("[0-9][0-9]_*"), std::string::npos);
}

}  // namespace
