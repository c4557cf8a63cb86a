// One of several processes that share a job: they see one folder, and exchange files in it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct JobRank {
  int rank = 0;        // 0 … size - 1
  int size = 1;        // processes
  std::string launch;  // the same for all of one start, another one for the next; may be empty
  double patience_s = 3600;  // how long to wait for a file when no other one appears

  bool IsFirst() const { return rank == 0; }
  bool IsShared() const { return size > 1; }
  // Item `i` is worked on by process i mod size.
  bool IsMine(std::size_t item) const {
    return item % static_cast<std::size_t>(size) == static_cast<std::size_t>(rank);
  }
};

// Value of an environment variable, null when it is not set (std::getenv).
using EnvironmentLookup = std::function<const char*(const char*)>;

// What the launcher says. `jobs`: "local" (one process), "mpi" (started by mpirun, mpiexec or srun)
// or "slurm" (a task of a job array or of srun). Throws UsageError for another word, or when there
// is no such launcher.
JobRank FindJobRank(const std::string& jobs, const EnvironmentLookup& environment);

// Waits until all `paths` are there; they must be written atomically. Throws Error naming the first
// missing one when none appeared for rank.patience_s seconds, CancelledError.
void WaitForFiles(const std::vector<std::filesystem::path>& paths, const JobRank& rank,
                  const JobControl& job);

// Makes `path` hold `text`. The first process calls `reset` before it replaces another text; the
// others wait until it has.
void AgreeOnStamp(const std::filesystem::path& path, const std::string& text,
                  const std::function<void()>& reset, const JobRank& rank, const JobControl& job);

}  // namespace colmap_ext
