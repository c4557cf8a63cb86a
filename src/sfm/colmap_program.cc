#include "colmap_ext/sfm/colmap_program.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// No display is needed or used; and OpenMP threads that spin while they wait cost COLMAP 2 to 4
// times the CPU time on small machines.
const std::map<std::string, std::string>& ColmapEnvironment() {
  static const std::map<std::string, std::string> environment = {{"QT_QPA_PLATFORM", "offscreen"},
                                                                 {"OMP_WAIT_POLICY", "passive"}};
  return environment;
}

std::filesystem::path FindColmap(const std::filesystem::path& colmap_path) {
  const std::string wanted = colmap_path.empty() ? "colmap" : colmap_path.string();
  const std::filesystem::path found = FindProgram(wanted);
  if (!found.empty()) return found;
  const std::string where = colmap_path.empty() ? "on the PATH" : "at " + wanted;
  throw Error("no `colmap` program found " + where +
              ": install it (Debian: apt-get install colmap) or give --colmap_path");
}

bool SpeaksOfAnError(const std::string& line) {
  static const std::vector<std::string> words = {"error",     "check failed", "failed to",
                                                 "terminate", "what():",      "abort"};
  std::string lower = line;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return lower.find(word) != std::string::npos;
  });
}

// Colours of a terminal, "ESC [ … m": 4.x writes them into pipes, too.
std::string WithoutColors(const std::string& line) {
  std::string plain;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != '\x1b') {
      plain += line[i];
      continue;
    }
    i = line.find('m', i);
    if (i == std::string::npos) break;
  }
  return plain;
}

std::string Trimmed(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

std::string FailureText(const std::string& command, const ColmapRun& run,
                        const std::filesystem::path& log_path) {
  return "`colmap " + command + "` failed with exit code " + std::to_string(run.exit_code) +
         ": \"" + run.message + "\"; full output: " + log_path.string();
}

}  // namespace

std::string LastMeaningfulLine(const std::string& output) {
  std::istringstream lines(output);
  std::string line, last, last_error;
  while (std::getline(lines, line)) {
    line = Trimmed(WithoutColors(line));
    if (line.empty()) continue;
    last = line;
    // glog's stack trace follows the message: the frames say nothing to a user.
    if (SpeaksOfAnError(line) && line.rfind("@", 0) != 0 && line.rfind("***", 0) != 0) {
      last_error = line;
    }
  }
  return last_error.empty() ? last : last_error;
}

ColmapProgram::ColmapProgram(const std::filesystem::path& colmap_path)
    : path_(FindColmap(colmap_path)) {
  const std::string program = path_.string();
  dialect_ = std::make_unique<ColmapDialect>([program](const std::string& command) {
    ChildProcessOptions options;
    options.environment = ColmapEnvironment();
    options.arguments = {program, command};
    if (command != "help") options.arguments.push_back("-h");
    return RunChildProcess(options, JobControl()).output;
  });
}

ColmapRun ColmapProgram::RunAnyway(const std::string& command, const ColmapOptions& options,
                                   const std::filesystem::path& log_path, const JobControl& job) {
  ChildProcessOptions child;
  child.environment = ColmapEnvironment();
  child.log_path = log_path;
  // The SIFT of COLMAP 3.8 reads what lay on its stack: a few descriptors at the borders of photos
  // change with the addresses (measured: 4 of 7 runs gave others; with fixed ones none of 18).
  child.fixed_addresses = true;
  child.arguments = {path_.string(), command};
  for (std::string& argument : dialect_->Arguments(command, options)) {
    child.arguments.push_back(std::move(argument));
  }
  const ChildProcessResult result = RunChildProcess(child, job);
  return {result.exit_code, LastMeaningfulLine(result.output)};
}

void ColmapProgram::Run(const std::string& command, const ColmapOptions& options,
                        const std::filesystem::path& log_path, const JobControl& job) {
  const ColmapRun run = RunAnyway(command, options, log_path, job);
  if (run.exit_code != 0) throw Error(FailureText(command, run, log_path));
}

ColmapRun ColmapProgram::TryRun(const std::string& command, const ColmapOptions& options,
                                const std::filesystem::path& log_path, const JobControl& job) {
  const ColmapRun run = RunAnyway(command, options, log_path, job);
  if (run.exit_code > 1) throw Error(FailureText(command, run, log_path));
  return run;
}

}  // namespace colmap_ext
