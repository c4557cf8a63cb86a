// Runs the `colmap` program, in the background of its own log files.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "colmap_ext/sfm/colmap_dialect.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// What one run of a subcommand cost.
struct ColmapRun {
  double wall_s = 0;
  double cpu_s = 0;
};

class ColmapProgram {
 public:
  // `colmap_path`: the program, or empty for `colmap` on the PATH. Throws Error saying what to
  // install when it is not there, or is not COLMAP.
  explicit ColmapProgram(const std::filesystem::path& colmap_path);

  const std::filesystem::path& path() const { return path_; }
  ColmapDialect& dialect() { return *dialect_; }

  // Runs `colmap <command>` with `options` (3.8's spelling, see ColmapDialect), without a display
  // and without spinning OpenMP threads. Output is appended to `log_path`. Throws Error with the
  // last meaningful line of the output and the log's path when the exit code is not 0, and
  // CancelledError when `job` is cancelled.
  ColmapRun Run(const std::string& command, const ColmapOptions& options,
                const std::filesystem::path& log_path, const JobControl& job);

 private:
  std::filesystem::path path_;
  std::unique_ptr<ColmapDialect> dialect_;
};

// The line of a program's output that says most about why it failed: the last one that speaks of an
// error, else the last one that is not blank; "" when there is none.
std::string LastMeaningfulLine(const std::string& output);

}  // namespace colmap_ext
