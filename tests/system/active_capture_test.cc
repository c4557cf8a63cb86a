// The main job as a user runs it: simulated sessions, a person's photos, and what can go wrong.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/files.h"
#include "orbit_photos.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json ReadJson(const fs::path& path) { return json::parse(ReadFile(path)); }

class SimulatedCapture : public ProgramTest {
 protected:
  static std::vector<std::string> Arguments(const fs::path& workspace) {
    return {"active_capture",
            "--workspace_path",
            workspace.string(),
            "--scene",
            "boxes",
            "--Session.max_iterations",
            "2",
            "--InitialFlight.num_views",
            "28",
            "--Session.vehicle",
            "embedded",
            "--Session.pictures",
            "0"};
  }

  // Starts the program, kills it with SIGKILL after `seconds`, and waits for its end.
  static void RunAndKill(const std::vector<std::string>& arguments, double seconds) {
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), COLMAP_EXT_PROGRAM);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      if (freopen("/dev/null", "w", stderr) == nullptr) _exit(127);
      execv(COLMAP_EXT_PROGRAM, pointers.data());
      _exit(127);
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
};

TEST_F(SimulatedCapture, SubmodularViewsCoverAndRegisterWithTheLastFlightCutToWhatIsLeft) {
  std::vector<std::string> arguments = Arguments(folder_ / "w");
  arguments.insert(arguments.end(),
                   {"--NextBestView.strategy", "submodular", "--NextBestView.num_views", "6",
                    "--Session.max_photos", "32", "--Mission.min_relative_height_m", "50"});
  *std::next(std::ranges::find(arguments, "--Session.max_iterations")) = "5";
  const ChildProcessResult result = Run(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("no mission file: mission: waypoint 0 is only"), std::string::npos)
      << "a path too low for a mission ends no session";
  const json summary = ReadJson(folder_ / "w" / "summary.json");
  ASSERT_EQ(summary["iterations"].size(), 2U);
  const json& second = summary["iterations"][1];
  EXPECT_EQ(second["photos"], 32) << "28 and four of six";
  EXPECT_EQ(summary["finished"], "view_limit");
  EXPECT_EQ(summary["iterations"][0]["planned_views"], 4);
  EXPECT_EQ(second["planned_views"], 6) << "for whoever goes on with a higher limit";
  EXPECT_EQ(second["registered"], second["photos"]);
  EXPECT_GT(second["covered_ratio"], summary["iterations"][0]["covered_ratio"]);
}

TEST_F(SimulatedCapture, CoverageRisesAndEveryFileIsThere) {
  const fs::path workspace = folder_ / "w";
  std::vector<std::string> arguments = Arguments(workspace);
  arguments.back() = "1";
  const ChildProcessResult result = Run(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const json summary = ReadJson(workspace / "summary.json");
  ASSERT_EQ(summary["iterations"].size(), 2U);
  EXPECT_EQ(summary["finished"], "iteration_limit");
  const json& first = summary["iterations"][0];
  const json& second = summary["iterations"][1];
  EXPECT_EQ(first["photos"], 28);
  EXPECT_EQ(first["registered"], 28);
  EXPECT_GT(second["registered"], first["registered"]);
  EXPECT_GT(second["covered_ratio"], first["covered_ratio"]);
  EXPECT_LT(second["mean_error_m"], 0.2) << "of buildings 1.6 m high";
  for (const char* name :
       {"sparse/images.bin", "fused.ply", "surface.ply", "coverage.ply", "coverage.json",
        "views.json", "path.json", "timing.json", "pictures/coverage.png", "pictures/path.png",
        "pictures/superpixels.png", "pictures/confidence.png"}) {
    EXPECT_TRUE(fs::exists(workspace / "iterations" / "001" / name)) << name;
  }
  const json timing = ReadJson(workspace / "iterations" / "000" / "timing.json");
  for (const char* stage :
       {"sparse", "superpixels", "stereo", "fusion", "surface", "coverage", "nbv", "path"}) {
    EXPECT_GE(timing[stage]["wall_s"], 0.0) << stage;
  }
  EXPECT_TRUE(fs::exists(workspace / "report" / "index.html"));
  const json path = ReadJson(workspace / "iterations" / "000" / "path.json");
  EXPECT_GE(path["min_clearance_m"], 0.3);
  EXPECT_NE(result.output.find("covered"), std::string::npos) << "no summary table";
}

TEST_F(SimulatedCapture, KilledSessionEndsWithTheSameResult) {
  const fs::path whole = folder_ / "whole";
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(Run(Arguments(whole)).exit_code, 0);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const fs::path killed = folder_ / "killed";
  for (const double share : {0.25, 0.45, 0.65}) RunAndKill(Arguments(killed), share * seconds);
  const ChildProcessResult result = Run(Arguments(killed));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* name : {"sparse/images.bin", "sparse/points3D.bin", "stereo.bin", "surface.ply",
                           "coverage.ply", "views.json", "path.json"}) {
    EXPECT_EQ(ReadFile(whole / "iterations" / "001" / name),
              ReadFile(killed / "iterations" / "001" / name))
        << name;
  }
}

class OwnPhotos : public OrbitPhotos {
 protected:
  std::vector<std::string> Arguments(const fs::path& photos) const {
    return {"active_capture", "--workspace_path",   (folder_ / "w").string(),
            "--image_path",   photos.string(),      "--preset",
            "indoor",         "--Session.pictures", "0"};
  }
};

TEST_F(OwnPhotos, CoverageViewsPathAndMissionThenOnlyTheNewOnes) {
  const fs::path photos = folder_ / "photos";
  RenderOrbit(photos, 0, 20);
  ChildProcessResult result = Run(Arguments(photos));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const fs::path iterations = folder_ / "w" / "iterations";
  EXPECT_TRUE(fs::exists(iterations / "000" / "coverage.json"));
  // Photos that do not say how high they were taken make no mission with heights above take-off.
  EXPECT_NE(result.output.find("no mission file: the photos do not say"), std::string::npos);
  EXPECT_FALSE(fs::exists(iterations / "000" / "mission.plan"));

  result = Run(Arguments(photos));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.output.find("No new photos"), std::string::npos) << result.output;

  RenderOrbit(photos, 20, 4);
  std::vector<std::string> with_height = Arguments(photos);
  with_height.insert(with_height.end(), {"--Mission.home_below_origin_m", "10"});
  result = Run(with_height);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const json summary = ReadJson(folder_ / "w" / "summary.json");
  ASSERT_EQ(summary["iterations"].size(), 2U);
  EXPECT_EQ(summary["iterations"][1]["photos"], 24);
  EXPECT_EQ(summary["iterations"][1]["registered"], 24);
  EXPECT_NE(result.output.find("features of 4 photos"), std::string::npos) << result.output;
  // Photos that the new ones do not reach keep the meshes that the first command left.
  EXPECT_LT(fs::file_size(iterations / "001" / "stereo.bin"),
            fs::file_size(iterations / "000" / "stereo.bin"));
  const json plan = ReadJson(iterations / "001" / "mission.plan");
  EXPECT_EQ(plan["fileType"], "Plan");
  EXPECT_GT(plan["mission"]["items"].size(), 5U);

  // Each command by itself takes the session's folder.
  const std::string workspace = (folder_ / "w").string();
  for (const char* verb : {"surface_reconstructor", "coverage_evaluator", "view_planner",
                           "path_planner", "report_generator"}) {
    const ChildProcessResult single = Run({verb, "--workspace_path", workspace});
    EXPECT_EQ(single.exit_code, 0) << verb << ": " << single.output;
  }
  result = Run({"mission_exporter", "--workspace_path", workspace, "--format", "geojson",
                "--output_path", (folder_ / "path.geojson").string(),
                "--Mission.home_below_origin_m", "10"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(ReadJson(folder_ / "path.geojson")["type"], "FeatureCollection");
}

TEST_F(OwnPhotos, WithoutGpsCoverageIsWrittenAndPlanningRefused) {
  const fs::path photos = folder_ / "photos";
  RenderOrbit(photos, 0, 20);
  for (const std::string& name : ListPhotos(photos)) {
    // A file with another first segment: JPEG without its EXIF (APP1).
    std::string bytes = ReadFile(photos / name);
    const std::size_t exif = bytes.find("Exif");
    ASSERT_NE(exif, std::string::npos);
    bytes.replace(exif, 4, "none");
    WriteFileAtomically(photos / name, bytes);
  }
  std::vector<std::string> arguments = Arguments(photos);
  const ChildProcessResult result = Run(arguments);
  ExpectFailure(result, 1, {"no flight was planned", "GPS", "--geo_path"});
  EXPECT_TRUE(fs::exists(folder_ / "w" / "iterations" / "000" / "coverage.ply"));
  EXPECT_FALSE(fs::exists(folder_ / "w" / "iterations" / "000" / "mission.plan"));
}

TEST_F(OwnPhotos, OnePhoto) {
  RenderOrbit(folder_ / "photos", 0, 1);
  ExpectFailure(Run(Arguments(folder_ / "photos")), 1, {"photo"});
}

TEST_F(OwnPhotos, TruncatedPhotoIsNamed) {
  const fs::path photos = folder_ / "photos";
  RenderOrbit(photos, 0, 4);
  const std::string bytes = ReadFile(photos / "orbit_02.jpg");
  WriteFileAtomically(photos / "orbit_02.jpg", bytes.substr(0, bytes.size() / 2));
  ExpectFailure(Run(Arguments(photos)), 1, {"orbit_02.jpg"});
}

TEST_F(OwnPhotos, PhotosWithoutOverlap) {
  const fs::path photos = folder_ / "photos";
  RenderOrbit(photos, 0, 13);
  for (int i = 0; i < 13; ++i) {  // opposite sides only
    char name[32];
    std::snprintf(name, sizeof name, "orbit_%02d.jpg", i);
    if (i % 12 != 0) fs::remove(photos / name);
  }
  ExpectFailure(Run(Arguments(photos)), 1, {"photo"});
  EXPECT_EQ(ListPhotos(photos).size(), 2U);
}

TEST_F(OwnPhotos, CorruptDatabase) {
  const fs::path photos = folder_ / "photos";
  RenderOrbit(photos, 0, 4);
  WriteFileAtomically(folder_ / "w" / "database.db", std::string(8192, 'x'));
  ExpectFailure(Run(Arguments(photos)), 1, {"database.db"});
  EXPECT_EQ(ReadFile(folder_ / "w" / "database.db"), std::string(8192, 'x')) << "changed";
}

TEST_F(OwnPhotos, WorkspaceThatCannotBeWritten) {
  RenderOrbit(folder_ / "photos", 0, 1);
  std::vector<std::string> arguments = Arguments(folder_ / "photos");
  arguments[2] = "/proc/colmap_ext_workspace";
  ExpectFailure(Run(arguments), 1, {"/proc/colmap_ext_workspace"});
}

}  // namespace
}  // namespace colmap_ext
