// One command by four processes of mpirun: the same files as by one process.
#include <gtest/gtest.h>

#include <map>

#include "colmap_ext/util/files.h"
#include "small_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class FourProcesses : public SmallSite {
 protected:
  std::vector<std::string> Arguments(const std::string& command, const std::string& output,
                                     std::vector<std::string> more) const {
    std::vector<std::string> arguments = {command,
                                          "--input_path",
                                          (folder_ / "sparse").string(),
                                          "--image_path",
                                          (folder_ / "images").string(),
                                          "--output_path",
                                          (folder_ / output).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static ChildProcessResult RunByFour(std::vector<std::string> arguments) {
    ChildProcessOptions options;
    options.arguments = {"mpirun", "--oversubscribe", "--bind-to", "none", "-n",
                         "4",      COLMAP_EXT_PROGRAM};
    options.environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                           {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"}};
    arguments.insert(arguments.end(), {"--jobs", "mpi", "--jobs_wait_s", "300"});
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    return RunChildProcess(options, JobControl());
  }

  std::map<std::string, std::string> FilesOf(const std::string& output) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / output)) {
      if (!entry.is_regular_file()) continue;
      files[entry.path().lexically_relative(folder_ / output)] = ReadFile(entry.path());
    }
    return files;
  }

  void ExpectSameResult(const std::string& command, const std::vector<std::string>& more = {}) {
    if (FindProgram("mpirun").empty()) GTEST_SKIP() << "no mpirun";
    const ChildProcessResult one = Run(Arguments(command, "one", more));
    ASSERT_EQ(one.exit_code, 0) << one.output;
    const ChildProcessResult four = RunByFour(Arguments(command, "four", more));
    ASSERT_EQ(four.exit_code, 0) << four.output;
    const auto expected = FilesOf("one"), found = FilesOf("four");
    EXPECT_EQ(found.size(), expected.size());
    for (const auto& [name, content] : expected) {
      ASSERT_TRUE(found.contains(name)) << name;
      EXPECT_TRUE(found.at(name) == content) << name << " differs";
    }
  }
};

TEST_F(FourProcesses, SuperpixelStereo) { ExpectSameResult("superpixel_stereo"); }

TEST_F(FourProcesses, DenseReconstructor) {
  ExpectSameResult("dense_reconstructor",
                   {"--backend", "builtin", "--DenseStereo.max_width_px", "320"});
}

TEST_F(FourProcesses, WithoutALauncherIsWrongUsage) {
  ExpectFailure(Run(Arguments("superpixel_stereo", "out", {"--jobs", "mpi"})), 2, {"mpirun"});
  ExpectFailure(Run(Arguments("dense_reconstructor", "out", {"--jobs", "slurm"})), 2, {"sbatch"});
}

}  // namespace
}  // namespace colmap_ext
