// A path and a frame for tests of mission files, and independent readers of what was written.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "colmap_ext/mission/mission.h"
#include "colmap_ext/util/child_process.h"

namespace colmap_ext {

inline WorldFrame FrameOnEarth() { return {true, GeoPosition{47.4, 8.5, 450}}; }

inline FlightPath TwoViewsAndATurn() {
  FlightPath path;
  path.waypoints.push_back({{0, 0, 12}, {0, 0}, -1});
  path.waypoints.push_back({{10, 20, 15}, {DegToRad(-90), DegToRad(-30)}, 7});
  path.waypoints.push_back({{-30, 5, 18}, {DegToRad(45), DegToRad(10)}, 8});
  path.length_m = 66;
  path.duration_s = 40;
  return path;
}

inline Mission MissionOf(const MissionOptions& options) {
  return PrepareMission(TwoViewsAndATurn(), FrameOnEarth(), options);
}

inline std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

// A folder that is removed again.
class MissionFiles : public ::testing::Test {
 protected:
  MissionFiles()
      : folder_(std::filesystem::path(::testing::TempDir()) /
                ("colmap_ext_mission_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~MissionFiles() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  // What a program prints; fails unless it succeeds.
  std::string Output(const std::vector<std::string>& arguments) const {
    ChildProcessOptions options;
    options.arguments = arguments;
    const ChildProcessResult result = RunChildProcess(options, JobControl());
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result.output;
  }

  std::filesystem::path folder_;
};

}  // namespace colmap_ext
