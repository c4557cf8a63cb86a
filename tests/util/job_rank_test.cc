#include "colmap_ext/util/job_rank.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <map>
#include <thread>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

JobRank Find(const std::string& jobs, std::map<std::string, std::string> environment) {
  return FindJobRank(jobs, [&](const char* name) -> const char* {
    const auto found = environment.find(name);
    return found == environment.end() ? nullptr : found->second.c_str();
  });
}

TEST(JobRank, LocalIsOneProcessWhateverTheEnvironment) {
  const JobRank rank = Find("local", {{"OMPI_COMM_WORLD_RANK", "3"}});
  EXPECT_EQ(rank.size, 1);
  EXPECT_TRUE(rank.IsFirst());
  EXPECT_FALSE(rank.IsShared());
  EXPECT_TRUE(rank.IsMine(7));
}

TEST(JobRank, EveryItemBelongsToOneProcess) {
  for (std::size_t item = 0; item < 20; ++item) {
    int owners = 0;
    for (int r = 0; r < 3; ++r) owners += JobRank{r, 3, ""}.IsMine(item);
    EXPECT_EQ(owners, 1) << item;
  }
}

TEST(JobRank, MpiLaunchersSayWhoAProcessIs) {
  const JobRank open_mpi = Find("mpi", {{"OMPI_COMM_WORLD_RANK", "2"},
                                        {"OMPI_COMM_WORLD_SIZE", "4"},
                                        {"PMIX_NAMESPACE", "12/3"},
                                        {"SLURM_PROCID", "0"}});
  EXPECT_EQ(open_mpi.rank, 2);
  EXPECT_EQ(open_mpi.size, 4);
  EXPECT_EQ(open_mpi.launch, "12_3") << "is a part of a folder's name";
  EXPECT_EQ(Find("mpi", {{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}).rank, 1);
  EXPECT_EQ(Find("mpi", {{"SLURM_PROCID", "5"}, {"SLURM_NTASKS", "8"}}).size, 8);
}

TEST(JobRank, TasksOfAnArrayMayBeginAnywhereAndLeaveSteps) {
  std::map<std::string, std::string> task = {{"SLURM_ARRAY_TASK_ID", "14"},
                                             {"SLURM_ARRAY_TASK_MIN", "10"},
                                             {"SLURM_ARRAY_TASK_MAX", "16"},
                                             {"SLURM_ARRAY_TASK_COUNT", "4"},
                                             {"SLURM_ARRAY_JOB_ID", "77"}};
  const JobRank rank = Find("slurm", task);
  EXPECT_EQ(rank.rank, 2);
  EXPECT_EQ(rank.size, 4);
  EXPECT_EQ(rank.launch, "77");
  task["SLURM_ARRAY_TASK_ID"] = "13";
  EXPECT_THROW(Find("slurm", task), UsageError);
}

TEST(JobRank, WithoutItsLauncherIsWrongUsage) {
  EXPECT_THROW(Find("mpi", {}), UsageError);
  EXPECT_THROW(Find("slurm", {}), UsageError);
  EXPECT_THROW(Find("cloud", {}), UsageError);
  EXPECT_THROW(Find("mpi", {{"PMI_RANK", "x"}, {"PMI_SIZE", "2"}}), UsageError);
  EXPECT_THROW(Find("mpi", {{"PMI_RANK", "2"}, {"PMI_SIZE", "2"}}), UsageError);
  EXPECT_THROW(Find("mpi", {{"PMI_RANK", "0"}}), UsageError);
}

class SharedFolder : public ::testing::Test {
 protected:
  SharedFolder()
      : folder_(fs::path(::testing::TempDir()) / ("colmap_ext_jobs_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~SharedFolder() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(SharedFolder, WaitsUntilTheLastFileIsThere) {
  const std::vector<fs::path> paths = {folder_ / "a", folder_ / "b"};
  std::jthread other([&] {
    for (const fs::path& path : paths) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      WriteFileAtomically(path, "x");
    }
  });
  WaitForFiles(paths, {0, 2, ""}, JobControl());
  EXPECT_TRUE(fs::exists(paths[1]));
}

TEST_F(SharedFolder, PatienceEndsWithTheNameOfTheMissingFile) {
  WriteFileAtomically(folder_ / "a", "x");
  try {
    WaitForFiles({folder_ / "a", folder_ / "b"}, {0, 2, "", 0.05}, JobControl());
    FAIL() << "did not end";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find((folder_ / "b").string()), std::string::npos);
  }
}

TEST_F(SharedFolder, WaitingCanBeStopped) {
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(WaitForFiles({folder_ / "a"}, {0, 2, ""}, JobControl(nullptr, &cancel)),
               CancelledError);
}

TEST_F(SharedFolder, OnlyTheFirstResetsAndTheOthersWaitForIt) {
  const fs::path stamp = folder_ / "stamp";
  WriteFileAtomically(stamp, "old");
  int resets = 0;
  const auto reset = [&] { ++resets; };
  EXPECT_THROW(AgreeOnStamp(stamp, "new", reset, {1, 2, "", 0.05}, JobControl()), Error);
  EXPECT_EQ(ReadFile(stamp), "old");
  std::jthread second([&] { AgreeOnStamp(stamp, "new", reset, {1, 2, ""}, JobControl()); });
  AgreeOnStamp(stamp, "new", reset, {0, 2, ""}, JobControl());
  second.join();
  EXPECT_EQ(resets, 1);
  AgreeOnStamp(stamp, "new", reset, {0, 2, ""}, JobControl());
  EXPECT_EQ(resets, 1) << "agreed already";
}

}  // namespace
}  // namespace colmap_ext
