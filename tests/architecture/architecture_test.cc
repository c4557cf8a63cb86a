// Reads every #include of our own headers and fails on an arrow that docs/architecture.md does not
// have, and on files and functions that have grown too long.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {
namespace fs = std::filesystem;

const fs::path kRoot = COLMAP_EXT_SOURCE_DIR;

// Direct arrows; what an arrow's end may include comes with it.
const std::map<std::string, std::set<std::string>> kArrows = {
    {"util", {}},
    {"mavlink", {"util"}},
    {"geom", {"util"}},
    {"scene", {"geom"}},
    {"sfm", {"scene"}},
    {"mvs", {"scene"}},
    {"surface", {"scene"}},
    {"coverage", {"scene"}},
    {"nbv", {"coverage"}},
    {"path", {"scene"}},
    {"mission", {"scene"}},
    {"flight", {"mission", "mavlink", "path"}},
    {"sim", {"mission", "mavlink"}},
    {"dense", {"scene"}},
    {"eval", {"scene"}},
    {"report", {"scene"}},
    {"session",
     {"sfm", "mvs", "surface", "coverage", "nbv", "path", "mission", "flight", "sim", "dense",
      "eval", "report"}},
};

std::set<std::string> Reachable(const std::string& module) {
  std::set<std::string> reached = {module};
  for (const std::string& next : kArrows.at(module)) reached.merge(Reachable(next));
  return reached;
}

std::vector<fs::path> SourcesBelow(const fs::path& folder) {
  std::vector<fs::path> sources;
  if (!fs::exists(folder)) return sources;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension();
    if (extension == ".cc" || extension == ".h") sources.push_back(entry.path());
  }
  return sources;
}

std::vector<std::string> LinesOf(const fs::path& path) {
  std::ifstream stream(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Architecture, ModulesIncludeOnlyWhatTheirArrowsAllow) {
  const std::regex include(R"(^\s*#include\s+"(?:colmap_ext/)?([a-z0-9_]+)/)");
  std::size_t arrows_seen = 0;
  for (const auto& [module, unused] : kArrows) {
    const std::set<std::string> allowed = Reachable(module);
    for (const char* tree : {"include/colmap_ext", "src"}) {
      for (const fs::path& file : SourcesBelow(kRoot / tree / module)) {
        for (const std::string& line : LinesOf(file)) {
          std::smatch match;
          if (!std::regex_search(line, match, include) || !kArrows.contains(match[1])) continue;
          ++arrows_seen;
          EXPECT_TRUE(allowed.contains(match[1]))
              << file << ": " << module << " may not include " << match[1];
        }
      }
    }
  }
  EXPECT_GT(arrows_seen, 50U) << "the pattern no longer finds includes";
}

TEST(Architecture, EveryModuleIsKnown) {
  for (const char* tree : {"include/colmap_ext", "src"}) {
    for (const auto& entry : fs::directory_iterator(kRoot / tree)) {
      if (entry.is_directory()) {
        EXPECT_TRUE(kArrows.contains(entry.path().filename().string())) << entry.path();
      }
    }
  }
}

TEST(Architecture, FilesStayBelow500Lines) {
  for (const char* tree : {"include", "src", "colmap_ext", "tests", "bench"}) {
    for (const fs::path& file : SourcesBelow(kRoot / tree)) {
      EXPECT_LE(LinesOf(file).size(), 500U) << file;
    }
  }
}

// Google style puts a function's closing brace in column 0 after its opening line.
TEST(Architecture, FunctionsStayBelow100Lines) {
  const std::regex opening(R"(^[A-Za-z].*[^;]\{$)");
  for (const char* tree : {"src", "colmap_ext"}) {
    for (const fs::path& file : SourcesBelow(kRoot / tree)) {
      const std::vector<std::string> lines = LinesOf(file);
      std::size_t start = 0;
      bool is_inside = false;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        const bool opens =
            std::regex_match(lines[i], opening) && !lines[i].starts_with("namespace");
        if (opens && lines[i].find('(') != std::string::npos) {
          start = i;
          is_inside = true;
        }
        if (is_inside && lines[i] == "}") {
          EXPECT_LE(i - start, 100U) << file << ":" << start + 1;
          is_inside = false;
        }
      }
    }
  }
}

TEST(Architecture, HeadersHaveOneGuardEach) {
  for (const char* tree : {"include", "src", "colmap_ext"}) {
    for (const fs::path& file : SourcesBelow(kRoot / tree)) {
      if (file.extension() != ".h") continue;
      std::size_t guards = 0;
      for (const std::string& line : LinesOf(file)) guards += line == "#pragma once" ? 1U : 0U;
      EXPECT_EQ(guards, 1U) << file;
    }
  }
}

}  // namespace
