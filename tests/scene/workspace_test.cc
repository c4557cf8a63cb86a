#include "colmap_ext/scene/workspace.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

void WriteSparse(const std::filesystem::path& iteration, const std::string& extension) {
  for (const char* name : {"cameras", "images", "points3D"}) {
    WriteFileAtomically(iteration / "sparse" / (name + extension), "x");
  }
}

TEST(Workspace, IterationsHaveThreeDigits) {
  const Workspace workspace("/w");
  EXPECT_EQ(workspace.iteration(0), "/w/iterations/000");
  EXPECT_EQ(workspace.iteration(42), "/w/iterations/042");
  EXPECT_EQ(workspace.iteration(1234), "/w/iterations/1234");
  ExpectError([&] { workspace.iteration(-1); }, {"-1"});
}

TEST(Workspace, TheLatestIterationIsTheLastWithACompleteSparseModel) {
  const TestFolder folder;
  const Workspace workspace(folder.path());
  EXPECT_EQ(workspace.LatestIteration(), std::nullopt);
  std::filesystem::create_directories(workspace.iteration(0));
  EXPECT_EQ(workspace.LatestIteration(), std::nullopt);
  WriteSparse(workspace.iteration(0), ".txt");
  WriteSparse(workspace.iteration(2), ".bin");
  EXPECT_EQ(workspace.LatestIteration(), 2);
  WriteSparse(workspace.iteration(1000), ".bin");
  EXPECT_EQ(workspace.LatestIteration(), 1000);
  std::filesystem::remove(workspace.iteration(1000) / "sparse" / "images.bin");
  EXPECT_EQ(workspace.LatestIteration(), 2);
  // Folders that are no iterations.
  for (const char* name : {"0007", "backup", "9", "99999999999999"}) {
    WriteSparse(folder / "iterations" / name, ".bin");
  }
  EXPECT_EQ(workspace.LatestIteration(), 2);
}

}  // namespace
}  // namespace colmap_ext
