#include "session/child_program.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

class ChildProgramTest : public testing::Test {
 protected:
  ChildProgramTest() : folder_(std::filesystem::path(testing::TempDir()) / FolderName()) {
    std::filesystem::create_directories(folder_);
  }
  ~ChildProgramTest() override { std::filesystem::remove_all(folder_); }

  static std::string FolderName() {
    return std::string("child_") + testing::UnitTest::GetInstance()->current_test_info()->name() +
           std::to_string(getpid());
  }
  std::unique_ptr<ChildProgram> Start(const std::string& script) const {
    return std::make_unique<ChildProgram>(std::vector<std::string>{"/bin/sh", "-c", script},
                                          folder_ / "log");
  }
  // The number that the script wrote; 0: not yet.
  pid_t ReadPid() const {
    std::ifstream stream(folder_ / "pid");
    pid_t pid = 0;
    stream >> pid;
    return pid;
  }
  std::string WritePid() const { return "echo $$ > '" + (folder_ / "pid").string() + "'; "; }

  std::filesystem::path folder_;
};

// A killed process that nobody waited for yet does not run any more either.
bool Runs(pid_t pid) {
  std::ifstream stream("/proc/" + std::to_string(pid) + "/stat");
  std::string number, name, state;
  stream >> number >> name >> state;
  return !state.empty() && state != "Z" && state != "X";
}

bool EndsSoon(pid_t pid) {
  for (int i = 0; i < 300 && Runs(pid); ++i) usleep(10000);
  return !Runs(pid);
}

TEST_F(ChildProgramTest, ALineThatItPrintsIsFoundOnlyWhole) {
  const auto child = Start("printf '{\"port\": '; sleep 0.2; echo '7}'; sleep 60");
  EXPECT_EQ(child->WaitForLine("{", 10, JobControl()), "{\"port\": 7}");
  EXPECT_TRUE(child->IsRunning());
}

TEST_F(ChildProgramTest, AProgramThatEndsEarlySaysWhy) {
  const auto child = Start("echo first; echo 'no such scene: x' >&2; exit 2");
  try {
    child->WaitForLine("{", 10, JobControl());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("no such scene: x"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("sh ended"), std::string::npos);
  }
}

TEST_F(ChildProgramTest, AProgramThatSaysNothingIsNotWaitedForLongerThanTold) {
  const auto child = Start("sleep 60");
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(child->WaitForLine("{", 0.3, JobControl()), Error);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(ChildProgramTest, WaitingCanBeCancelled) {
  const auto child = Start("sleep 60");
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(child->WaitForLine("{", 60, JobControl(nullptr, &cancel)), CancelledError);
}

TEST_F(ChildProgramTest, AMissingProgramIsNamed) {
  const ChildProgram child({"/no/such/program"}, folder_ / "log");
  EXPECT_THROW(child.WaitForLine("{", 10, JobControl()), Error);
  try {
    child.FailWithLastLine();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/no/such/program"), std::string::npos);
  }
}

TEST_F(ChildProgramTest, ItEndsWithItsOwner) {
  auto child = Start(WritePid() + "echo ready; sleep 60");
  child->WaitForLine("ready", 10, JobControl());
  const pid_t pid = ReadPid();
  ASSERT_GT(pid, 0);
  child.reset();
  EXPECT_TRUE(EndsSoon(pid));
}

TEST_F(ChildProgramTest, ItDoesNotOutliveAnOwnerThatIsKilled) {
  const pid_t owner = fork();
  if (owner == 0) {
    const auto child = Start(WritePid() + "echo ready; sleep 60");
    child->WaitForLine("ready", 10, JobControl());
    pause();
    _exit(0);
  }
  for (int i = 0; i < 1000 && ReadPid() == 0; ++i) usleep(10000);
  const pid_t pid = ReadPid();
  ASSERT_GT(pid, 0);
  EXPECT_TRUE(Runs(pid));
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  EXPECT_TRUE(EndsSoon(pid));
}

TEST(FindSibling, BesideThisProgramFirstThenOnThePath) {
  EXPECT_EQ(FindSibling("test_session").filename(), "test_session");
  EXPECT_TRUE(FindSibling("test_session").is_absolute());
  EXPECT_EQ(FindSibling("sh").filename(), "sh");
  EXPECT_THROW(FindSibling("no_such_program_of_ours"), Error);
}

}  // namespace
}  // namespace colmap_ext
