#include "colmap_ext/session/session_lock.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class SessionLockTest : public testing::Test {
 protected:
  SessionLockTest()
      : workspace_(fs::path(testing::TempDir()) / ("lock_" + std::to_string(getpid()))) {
    fs::create_directories(workspace_.root());
  }
  ~SessionLockTest() override { fs::remove_all(workspace_.root()); }

  Workspace workspace_;
};

TEST_F(SessionLockTest, TheSecondIsToldWhoHoldsIt) {
  EXPECT_FALSE(SessionLock::HolderOf(workspace_).has_value());
  {
    const SessionLock first(workspace_);
    EXPECT_EQ(SessionLock::HolderOf(workspace_), getpid());
    try {
      const SessionLock second(workspace_);
      ADD_FAILURE() << "both got it";
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(workspace_.root().string()), std::string::npos) << message;
      EXPECT_NE(message.find("process " + std::to_string(getpid())), std::string::npos) << message;
    }
    EXPECT_EQ(SessionLock::HolderOf(workspace_), getpid()) << "asking does not take it";
  }
  EXPECT_FALSE(SessionLock::HolderOf(workspace_).has_value());
  EXPECT_TRUE(fs::is_empty(workspace_.root())) << "nothing stays behind";
  const SessionLock again(workspace_);
}

}  // namespace
}  // namespace colmap_ext
