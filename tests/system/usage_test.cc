// The command line of the program, and bad input to whole commands.
#include <gtest/gtest.h>

#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {
namespace {

using Usage = ProgramTest;
using BadInput = ProgramTest;

TEST_F(Usage, HelpListsEveryCommand) {
  const ChildProcessResult result = Run({"help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* verb :
       {"sparse_updater", "superpixel_segmenter", "superpixel_stereo", "surface_reconstructor",
        "coverage_evaluator", "view_planner", "path_planner", "flight_planner", "mission_exporter",
        "active_capture", "scene_renderer", "model_evaluator", "report_generator"}) {
    EXPECT_NE(result.output.find(verb), std::string::npos) << verb;
    const ChildProcessResult help = Run({verb, "-h"});
    EXPECT_EQ(help.exit_code, 0) << verb;
    EXPECT_NE(help.output.find("--log_level"), std::string::npos) << verb;
  }
}

TEST_F(Usage, WrongUsageExitsWithTwo) {
  ExpectFailure(Run({"fly_away"}), 2, {"no such command", "fly_away"});
  ExpectFailure(Run({"veiw_planner"}), 2, {"no such command", "did you mean view_planner?"});
  ExpectFailure(Run({"active_capture", "--no_such_option", "1"}), 2, {"no_such_option"});
  ExpectFailure(Run({"active_capture"}), 2, {"--workspace_path"});
  ExpectFailure(Run({"view_planner", "--NextBestView.num_views", "many"}), 2,
                {"NextBestView.num_views", "whole number"});
  EXPECT_EQ(Run({}).exit_code, 2);
}

TEST_F(BadInput, NoSuchFolder) {
  ExpectFailure(Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--image_path",
                     (folder_ / "nowhere").string()}),
                1, {"nowhere", "no such folder"});
}

TEST_F(BadInput, EmptyFolder) {
  std::filesystem::create_directories(folder_ / "photos");
  ExpectFailure(Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--image_path",
                     (folder_ / "photos").string()}),
                1, {"photos", "no photo"});
}

TEST_F(BadInput, BothASceneAndPhotos) {
  ExpectFailure(Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--image_path",
                     folder_.string(), "--scene", "church"}),
                2, {"--scene", "--image_path"});
}

TEST_F(BadInput, UnknownScene) {
  ExpectFailure(
      Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--scene", "castle"}), 2,
      {"castle", "church"});
}

TEST_F(BadInput, NoColmapOnThePath) {
  ExpectFailure(
      Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--scene", "boxes"},
          {{"PATH", folder_.string()}}),
      1, {"colmap", "install"});
}

TEST_F(BadInput, WorkspaceThatIsAFile) {
  WriteFileAtomically(folder_ / "w", "not a folder");
  ExpectFailure(
      Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--scene", "boxes"}), 1,
      {"w"});
}

TEST_F(BadInput, OptionOutOfRange) {
  ExpectFailure(Run({"active_capture", "--workspace_path", (folder_ / "w").string(), "--scene",
                     "boxes", "--Session.max_iterations", "0"}),
                2, {"max_iterations"});
}

}  // namespace
}  // namespace colmap_ext
