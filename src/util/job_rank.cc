#include "colmap_ext/util/job_rank.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <thread>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Names of the variables in which a launcher says who a process is.
struct Launcher {
  const char* rank;
  const char* size;
  const char* launch;
};

constexpr Launcher kOpenMpi{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "PMIX_NAMESPACE"};
constexpr Launcher kMpich{"PMI_RANK", "PMI_SIZE", "PMI_PORT"};
constexpr Launcher kSlurmStep{"SLURM_PROCID", "SLURM_NTASKS", "SLURM_JOB_ID"};

int Number(const char* name, const EnvironmentLookup& environment) {
  const char* text = environment(name);
  int value = -1;
  if (text != nullptr) {
    const char* end = text + std::strlen(text);
    if (std::from_chars(text, end, value).ptr != end) value = -1;
  }
  if (value < 0) throw UsageError(std::string("the launcher's ") + name + " is no number");
  return value;
}

JobRank Checked(JobRank rank) {
  if (rank.size < 1 || rank.rank >= rank.size) {
    throw UsageError("the launcher counts processes wrongly: " + std::to_string(rank.rank) +
                     " of " + std::to_string(rank.size));
  }
  std::ranges::replace_if(
      rank.launch, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return rank;
}

JobRank RankFrom(const Launcher& launcher, const EnvironmentLookup& environment) {
  JobRank rank;
  rank.rank = Number(launcher.rank, environment);
  rank.size = Number(launcher.size, environment);
  const char* launch = environment(launcher.launch);
  if (launch != nullptr) rank.launch = launch;
  return Checked(rank);
}

// Task ids may begin anywhere and leave steps: --array=1-16, --array=0-30:2.
JobRank RankInArray(const EnvironmentLookup& environment) {
  const int first = Number("SLURM_ARRAY_TASK_MIN", environment);
  const int last = Number("SLURM_ARRAY_TASK_MAX", environment);
  JobRank rank;
  rank.size = Number("SLURM_ARRAY_TASK_COUNT", environment);
  const int step = rank.size > 1 ? (last - first) / (rank.size - 1) : 1;
  const int offset = Number("SLURM_ARRAY_TASK_ID", environment) - first;
  if (step < 1 || (rank.size - 1) * step != last - first || offset % step != 0) {
    throw UsageError("the task ids of the job array are not evenly spaced; use --array=0-N");
  }
  rank.rank = offset / step;
  const char* launch = environment("SLURM_ARRAY_JOB_ID");
  if (launch != nullptr) rank.launch = launch;
  return Checked(rank);
}

// Polls, slower and slower: a shared disk is not asked all the time.
class Patience {
 public:
  Patience(double seconds, const JobControl& job) : seconds_(seconds), job_(job) {}

  void Restart() {
    begin_ = std::chrono::steady_clock::now();
    pause_ = kShortest;
  }

  // False when it is over.
  bool Wait() {
    job_.ThrowIfCancelled();
    if (std::chrono::steady_clock::now() - begin_ > seconds_) return false;
    std::this_thread::sleep_for(pause_);
    pause_ = std::min(2 * pause_, kLongest);
    return true;
  }

 private:
  static constexpr std::chrono::milliseconds kShortest{2}, kLongest{250};
  std::chrono::duration<double> seconds_;
  const JobControl& job_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::milliseconds pause_ = kShortest;
};

// Empty when it is not there, even if it was a moment ago.
std::string TextIfThere(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

[[noreturn]] void FailToWait(const fs::path& path, const JobRank& rank) {
  throw Error(path.string() + ": another of the " + std::to_string(rank.size) +
              " processes did not write this within " + FormatNumber("%.0f s", rank.patience_s) +
              "; do all of them run, and see the same folder? The same command goes on");
}

}  // namespace

JobRank FindJobRank(const std::string& jobs, const EnvironmentLookup& environment) {
  if (jobs == "local") return {};
  if (jobs == "mpi") {
    for (const Launcher& launcher : {kOpenMpi, kMpich, kSlurmStep}) {
      if (environment(launcher.rank) != nullptr) return RankFrom(launcher, environment);
    }
    throw UsageError("--jobs mpi: start it by `mpirun -n 4 colmap_ext …` or `srun`");
  }
  if (jobs == "slurm") {
    if (environment("SLURM_ARRAY_TASK_ID") != nullptr) return RankInArray(environment);
    if (environment(kSlurmStep.rank) != nullptr) return RankFrom(kSlurmStep, environment);
    throw UsageError("--jobs slurm: start it by `sbatch --array=0-3` or `srun`");
  }
  throw UsageError("--jobs " + jobs + ": must be local, mpi or slurm");
}

void WaitForFiles(const std::vector<fs::path>& paths, const JobRank& rank, const JobControl& job) {
  Patience patience(rank.patience_s, job);
  std::vector<fs::path> missing = paths;
  while (true) {
    const auto appeared =
        std::erase_if(missing, [](const fs::path& path) { return fs::exists(path); });
    if (missing.empty()) return;
    if (appeared > 0) patience.Restart();
    if (!patience.Wait()) FailToWait(missing.front(), rank);
  }
}

void AgreeOnStamp(const fs::path& path, const std::string& text, const std::function<void()>& reset,
                  const JobRank& rank, const JobControl& job) {
  const auto agrees = [&] { return TextIfThere(path) == text; };
  if (rank.IsFirst()) {
    if (agrees()) return;
    reset();
    WriteFileAtomically(path, text);
    return;
  }
  Patience patience(rank.patience_s, job);
  while (!agrees()) {
    if (!patience.Wait()) FailToWait(path, rank);
  }
}

}  // namespace colmap_ext
