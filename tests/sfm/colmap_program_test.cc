#include "colmap_ext/sfm/colmap_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class ColmapProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("colmap_program_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // A program that answers as COLMAP does, and does `body` for the command "mapper".
  fs::path FakeColmap(const std::string& body) const {
    const fs::path path = folder_ / "fake_colmap";
    std::ofstream(path) << "#!/bin/sh\n"
                           "if [ \"$1\" = help ]; then printf 'COLMAP 3.8 --\\nAvailable commands:"
                           "\\n  mapper\\n'; exit 0; fi\n"
                           "if [ \"$2\" = -h ]; then echo '  --output_path arg'; exit 0; fi\n"
                        << body << "\n";
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }

  fs::path folder_;
};

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_F(ColmapProgramTest, SaysWhatToInstallWhenThereIsNone) {
  const std::string message = MessageOf([&] { ColmapProgram(folder_ / "none"); });
  EXPECT_NE(message.find("no `colmap` program found"), std::string::npos) << message;
  EXPECT_NE(message.find("apt-get install colmap"), std::string::npos);
  EXPECT_NE(message.find("--colmap_path"), std::string::npos);
}

TEST_F(ColmapProgramTest, RunsWithoutDisplayAndKeepsTheLog) {
  ColmapProgram program(FakeColmap("echo \"$QT_QPA_PLATFORM $OMP_WAIT_POLICY $*\""));
  const fs::path log = folder_ / "logs" / "mapper.log";
  program.Run("mapper", {{"output_path", "a b"}}, log, {});
  EXPECT_EQ(ReadFile(log), "offscreen passive mapper --output_path a b\n");
}

TEST_F(ColmapProgramTest, NamesTheErrorAndTheLogWhenTheProgramFails) {
  ColmapProgram program(FakeColmap("echo 'ERROR: no such thing'; echo; echo 'bye'; exit 3"));
  const fs::path log = folder_ / "mapper.log";
  const std::string message = MessageOf([&] { program.Run("mapper", {}, log, {}); });
  EXPECT_NE(message.find("`colmap mapper` failed with exit code 3"), std::string::npos) << message;
  EXPECT_NE(message.find("ERROR: no such thing"), std::string::npos);
  EXPECT_NE(message.find(log.string()), std::string::npos);
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(ColmapProgramTest, LetsTheCallerJudgeAFailureButNotACrash) {
  ColmapProgram program(FakeColmap("echo 'ERROR: no model'; exit 1"));
  const ColmapRun run = program.TryRun("mapper", {}, folder_ / "log", {});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.message, "ERROR: no model");
  ColmapProgram crashing(FakeColmap("kill -SEGV $$"));
  EXPECT_NE(MessageOf([&] { crashing.TryRun("mapper", {}, folder_ / "log", {}); }).find("139"),
            std::string::npos);
}

TEST_F(ColmapProgramTest, FindsTheRealColmapOnThePath) {
  ColmapProgram program("");
  EXPECT_TRUE(program.dialect().HasCommand("mapper"));
  EXPECT_TRUE(program.dialect().HasOption("feature_extractor", "SiftExtraction.use_gpu"));
  EXPECT_TRUE(program.dialect().HasOption("mapper", "Mapper.fix_existing_images"));
}

TEST(LastMeaningfulLine, PrefersErrorsAndSkipsStackTraces) {
  EXPECT_EQ(LastMeaningfulLine("a\nF0101 x.cc:1] Check failed: x\n*** Check failure ***\n"
                               "    @ 0x7f abort\n"),
            "F0101 x.cc:1] Check failed: x");
  EXPECT_EQ(LastMeaningfulLine("one\ntwo  \r\n\n"), "two");
  EXPECT_EQ(LastMeaningfulLine("\n \n"), "");
  EXPECT_EQ(LastMeaningfulLine("\x1b[0;31mE1 x.cc:1] Check failed: y\x1b[0m\n"),
            "E1 x.cc:1] Check failed: y");
}

}  // namespace
}  // namespace colmap_ext
