#include "session/flight_programs.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class FlightPrograms : public testing::Test {
 protected:
  FlightPrograms() : workspace_(fs::path(testing::TempDir()) / FolderName()) {
    fs::create_directories(workspace_.logs());
    inputs_.workspace_path = workspace_.root();
    inputs_.scene = "boxes";
    // Found on the PATH, as beside an installed program.
    for (const char* name : {"colmap_ext_dronesim", "colmap_ext_flightd"}) {
      WriteFileAtomically(workspace_.root() / "bin" / name, "#!/bin/sh\n");
      fs::permissions(workspace_.root() / "bin" / name, fs::perms::owner_all);
    }
    setenv("PATH", ((workspace_.root() / "bin").string() + ":" + getenv("PATH")).c_str(), 1);
  }
  ~FlightPrograms() override { fs::remove_all(workspace_.root()); }
  static std::string FolderName() { return "programs_" + std::to_string(getpid()); }

  // What follows an option; empty: it is not there.
  static std::string After(const std::vector<std::string>& arguments, const std::string& option) {
    const auto found = std::find(arguments.begin(), arguments.end(), option);
    return found == arguments.end() || found + 1 == arguments.end() ? "" : *(found + 1);
  }

  Workspace workspace_;
  SessionInputs inputs_;
  StageOptions options_;
};

TEST_F(FlightPrograms, TheDroneIsSafeAndReturnsAboveTheSite) {
  auto arguments = DroneArguments(inputs_, options_, workspace_, 12.3, 4711, "/out");
  EXPECT_EQ(fs::path(arguments[0]).filename(), "colmap_ext_dronesim");
  EXPECT_EQ(After(arguments, "--Drone.failsafes"), "safe");
  EXPECT_EQ(After(arguments, "--connection"), "udpout://127.0.0.1:4711");
  EXPECT_EQ(After(arguments, "--Drone.parameters"), "RTL_RETURN_ALT=28");
  EXPECT_EQ(After(arguments, "--scene"), "boxes");
  EXPECT_EQ(After(arguments, "--full_resolution"), "0");
  options_.session.personality = "ardupilot";
  options_.session.full_resolution = true;
  inputs_.scene.clear();
  inputs_.scene_path = "site.obj";
  arguments = DroneArguments(inputs_, options_, workspace_, 12.3, 4711, "/out");
  EXPECT_EQ(After(arguments, "--Drone.parameters"), "RTL_ALT=2800") << "centimetres";
  EXPECT_EQ(After(arguments, "--scene_path"), "site.obj");
  EXPECT_EQ(After(arguments, "--scene"), "");
  EXPECT_EQ(After(arguments, "--full_resolution"), "1");
}

TEST_F(FlightPrograms, BothProgramsRunOnOneClock) {
  options_.session.simulation_speed = 7.5;
  const auto drone = DroneArguments(inputs_, options_, workspace_, 0, 4711, "/out");
  const auto daemon = SimulationDaemonArguments(options_, workspace_, 4711, 8080);
  EXPECT_EQ(After(drone, "--speed"), "7.5");
  EXPECT_EQ(After(daemon, "--simulated_speed"), "7.5");
  EXPECT_EQ(After(daemon, "--connection"), "udpin://127.0.0.1:4711");
  EXPECT_EQ(After(daemon, "--picture_url"),
            "http://127.0.0.1:8080/pictures/{resolution}/img_{index5}.jpg");
}

TEST_F(FlightPrograms, TheSessionsOptionsReachThem) {
  options_.flight.settle_distance_m = 0.125;
  options_.simulation.seed = 77;
  DroneArguments(inputs_, options_, workspace_, 0, 4711, "/out");
  SimulationDaemonArguments(options_, workspace_, 4711, 8080);
  FlightOptions flight;
  OptionSet flight_set;
  BindOptions(flight_set, &flight);
  flight_set.ParseIniFile(workspace_.logs() / "flight.ini");
  EXPECT_EQ(flight.settle_distance_m, 0.125);
  EXPECT_NE(ReadFile(workspace_.logs() / "drone.ini").find("77"), std::string::npos);
}

TEST_F(FlightPrograms, ARealVehicleHasItsOwnClockAndPictures) {
  options_.session.vehicle = "serial:///dev/ttyACM0:57600";
  auto daemon = VehicleDaemonArguments(inputs_, options_, workspace_);
  EXPECT_EQ(After(daemon, "--connection"), options_.session.vehicle);
  EXPECT_EQ(After(daemon, "--simulated_speed"), "");
  EXPECT_EQ(After(daemon, "--picture_url"), "") << "as the camera says";
  inputs_.capture_folder = "/card";
  daemon = VehicleDaemonArguments(inputs_, options_, workspace_);
  EXPECT_EQ(After(daemon, "--capture_folder"), "/card");
}

TEST(FreeUdpPort, IsOne) {
  const int port = FreeUdpPort();
  EXPECT_GT(port, 1023);
  EXPECT_LT(port, 65536);
}

TEST(VehicleOption, IsAWordOrAConnection) {
  SessionOptions options;
  EXPECT_FALSE(options.IsRealVehicle());
  EXPECT_EQ(options.Check(), "");
  options.vehicle = "udpin://0.0.0.0:14550";
  EXPECT_TRUE(options.IsRealVehicle());
  EXPECT_EQ(options.Check(), "");
  options.vehicle = "embeded";
  EXPECT_THROW(options.Check(), UsageError);
  options.vehicle = "";
  EXPECT_NE(options.Check(), "");
  options.vehicle = "embedded";
  options.simulation_speed = 0;
  EXPECT_NE(options.Check(), "");
}

}  // namespace
}  // namespace colmap_ext
