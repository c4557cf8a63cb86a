#include "session/session_state.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

class SessionStateTest : public testing::Test {
 protected:
  SessionStateTest()
      : path_(std::filesystem::path(testing::TempDir()) /
              ("state_" + std::to_string(getpid()) + ".json")) {}
  ~SessionStateTest() override { std::filesystem::remove(path_); }

  std::filesystem::path path_;
};

TEST_F(SessionStateTest, ComesBackExactly) {
  SessionState state;
  state.source = "scene church";
  state.iterations_done = 3;
  state.next_view_id = 97;
  state.finished = "view_limit";
  state.region = RegionOfInterest{
      BoundingBox(Eigen::Vector3d(-1.0 / 3, 2, -0.1), Eigen::Vector3d(1, 1e9 / 7, 3))};
  state.site_gsd_mm = 167.0 / 7;
  WriteSessionState(state, path_);
  const SessionState read = ReadSessionState(path_);
  EXPECT_EQ(read.source, state.source);
  EXPECT_EQ(read.iterations_done, state.iterations_done);
  EXPECT_EQ(read.next_view_id, state.next_view_id);
  EXPECT_EQ(read.finished, state.finished);
  ASSERT_TRUE(read.region.has_value());
  EXPECT_EQ(read.region->box.min(), state.region->box.min());
  EXPECT_EQ(read.region->box.max(), state.region->box.max());
  EXPECT_EQ(read.site_gsd_mm, state.site_gsd_mm);
}

TEST_F(SessionStateTest, OptionalPartsMayBeMissing) {
  WriteSessionState(SessionState(), path_);
  const SessionState read = ReadSessionState(path_);
  EXPECT_FALSE(read.region.has_value());
  EXPECT_FALSE(read.site_gsd_mm.has_value());
  EXPECT_TRUE(read.finished.empty());
}

TEST_F(SessionStateTest, DamagedOrForeignFilesAreNamed) {
  for (const char* text : {"", "{", "[]", "{\"version\": 2}", "{\"version\": 1}",
                           "{\"version\": 1, \"source\": \"s\", \"iterations_done\": -1, "
                           "\"next_view_id\": 0, \"finished\": \"\"}"}) {
    WriteFileAtomically(path_, text);
    try {
      ReadSessionState(path_);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(path_.string()), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace colmap_ext
