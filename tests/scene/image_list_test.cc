#include "colmap_ext/scene/image_list.h"

#include <gtest/gtest.h>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/files.h"
#include "scene/sparse_model.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

TEST(ImageList, IsReadAsItWasWritten) {
  const TestFolder folder;
  const std::set<std::string> names = {"a.jpg", "north side/b 1.jpg", "ä.png"};
  WriteImageList(names, folder / "list.txt");
  EXPECT_EQ(ReadImageList(folder / "list.txt"), names);
}

TEST(ImageList, LeavesOutBlankLinesCommentsAndLineEnds) {
  const TestFolder folder;
  WriteFileAtomically(folder / "list.txt", std::string("# mine\r\n\n  a.jpg \r\n\tb.jpg"));
  EXPECT_EQ(ReadImageList(folder / "list.txt"), (std::set<std::string>{"a.jpg", "b.jpg"}));
}

TEST(ImageList, ThatNamesNothingOrIsNotThereIsRefused) {
  const TestFolder folder;
  WriteFileAtomically(folder / "list.txt", std::string("\n# nothing\n"));
  ExpectError([&] { ReadImageList(folder / "list.txt"); }, {"list.txt", "no photo"});
  ExpectError([&] { ReadImageList(folder / "none.txt"); }, {"none.txt"});
}

TEST(FirstFlightPhotos, AreThoseOfTheListElseOfTheFirstIteration) {
  const TestFolder folder;
  const Workspace workspace(folder / "w");
  ExpectError([&] { FirstFlightPhotos(workspace); }, {"000"});
  const Reconstruction model = MakeSparseModel();
  WriteReconstructionBinary(model, IterationFiles{workspace.iteration(0)}.sparse());
  std::set<std::string> registered;
  for (const auto& [id, image] : model.images) registered.insert(image.name);
  EXPECT_EQ(FirstFlightPhotos(workspace), registered);
  WriteImageList({"one.jpg"}, workspace.first_flight_txt());
  EXPECT_EQ(FirstFlightPhotos(workspace), std::set<std::string>{"one.jpg"});
}

}  // namespace
}  // namespace colmap_ext
