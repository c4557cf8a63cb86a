#include "sfm/update_lock.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

TEST(UpdateLock, LetsOneUpdateInAtATimeAndLeavesNothing) {
  const fs::path database = fs::path(testing::TempDir()) / "locked.db";
  std::optional<UpdateLock> first(database);
  EXPECT_TRUE(fs::exists(UpdateLock::PathFor(database)));
  try {
    const UpdateLock second(database);
    FAIL() << "two locks at once";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("another update"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("locked.db"), std::string::npos);
  }
  const UpdateLock other(fs::path(testing::TempDir()) / "other.db");  // is not concerned
  first.reset();
  EXPECT_FALSE(fs::exists(UpdateLock::PathFor(database)));
  EXPECT_NO_THROW(UpdateLock{database});
}

TEST(UpdateLock, SaysWhereItCannotBe) {
  EXPECT_THROW(UpdateLock(fs::path(testing::TempDir()) / "no_such_folder" / "a.db"), Error);
}

}  // namespace
}  // namespace colmap_ext
