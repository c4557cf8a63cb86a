// Runs the `colmap` program, in the background of its own log files.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "colmap_ext/sfm/colmap_dialect.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// How one run of a subcommand ended.
struct ColmapRun {
  int exit_code = 0;
  std::string message;  // the last meaningful line of its output
};

class ColmapProgram {
 public:
  // `colmap_path`: the program, or empty for `colmap` on the PATH. Throws Error saying what to
  // install when it is not there, or is not COLMAP.
  explicit ColmapProgram(const std::filesystem::path& colmap_path);

  const std::filesystem::path& path() const { return path_; }
  ColmapDialect& dialect() { return *dialect_; }

  // Runs `colmap <command>` with `options` (3.8's spelling, see ColmapDialect), without a display
  // and without spinning OpenMP threads. Output is appended to `log_path`. Throws Error when the
  // exit code is not 0, with the last meaningful line of the output and the log's path, and
  // CancelledError when `job` is cancelled. May be called from several threads once the command's
  // options were asked for.
  void Run(const std::string& command, const ColmapOptions& options,
           const std::filesystem::path& log_path, const JobControl& job);

  // The same for a command whose failure (exit code 1) is an answer: the caller looks at the
  // result. Throws Error for any other exit code.
  ColmapRun TryRun(const std::string& command, const ColmapOptions& options,
                   const std::filesystem::path& log_path, const JobControl& job);

 private:
  ColmapRun RunAnyway(const std::string& command, const ColmapOptions& options,
                      const std::filesystem::path& log_path, const JobControl& job);

  std::filesystem::path path_;
  std::unique_ptr<ColmapDialect> dialect_;
};

// The line of a program's output that says most about why it failed: the last one that speaks of an
// error, else the last one that is not blank; "" when there is none.
std::string LastMeaningfulLine(const std::string& output);

}  // namespace colmap_ext
