#include "job_options.h"

#include <cstdlib>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

void BindOptions(OptionSet& set, JobOptions* o) {
  set.Add("", "jobs", &o->jobs,
          "how the photos are split over processes: local (this one does all), mpi (those that "
          "mpirun or srun started), slurm (tasks of a job array, or of srun)");
  set.Add("", "jobs_wait_s", &o->wait_s,
          "how long a process waits for another one that writes nothing (seconds, >= 0)");
}

JobRank RankOf(const JobOptions& o) {
  if (!(o.wait_s >= 0)) throw UsageError("--jobs_wait_s must be at least 0");
  JobRank rank = FindJobRank(o.jobs, [](const char* name) { return std::getenv(name); });
  rank.patience_s = o.wait_s;
  return rank;
}

}  // namespace colmap_ext
