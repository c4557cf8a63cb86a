#include "colmap_ext/util/file_lock.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>
#include <string>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

fs::path LockPath() { return fs::path(testing::TempDir()) / "of_a_test.lock"; }

TEST(FileLock, OneAtATimeAndNothingIsLeft) {
  std::optional<FileLock> first(std::in_place, LockPath(), "busy");
  EXPECT_TRUE(FileLock::IsHeld(LockPath()));
  try {
    const FileLock second(LockPath(), "busy: somebody works here");
    FAIL() << "two locks at once";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "busy: somebody works here");
  }
  first.reset();
  EXPECT_FALSE(FileLock::IsHeld(LockPath()));
  EXPECT_FALSE(fs::exists(LockPath()));
}

TEST(FileLock, IsReleasedWhenItsProgramIsKilled) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const FileLock held(LockPath(), "busy");
    (void)!write(ready[1], "x", 1);
    pause();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_TRUE(FileLock::IsHeld(LockPath()));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(FileLock::IsHeld(LockPath()));
  EXPECT_NO_THROW(FileLock(LockPath(), "busy"));
  close(ready[0]);
  close(ready[1]);
}

TEST(FileLock, SaysWhereItCannotBe) {
  const fs::path path = fs::path(testing::TempDir()) / "no_such_folder" / "a.lock";
  try {
    const FileLock lock(path, "busy");
    FAIL() << "a lock in a folder that is not there";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace colmap_ext
