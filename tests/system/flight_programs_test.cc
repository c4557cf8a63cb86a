// Flight daemon and simulated drone as programs, flown by flight_client: what a person does.
#include "session/flight_programs.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "background_program.h"
#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/scene/workspace.h"
#include "program.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kViews = 5;

class FlightProgram : public ProgramTest {
 protected:
  FlightProgram() : workspace_(folder_ / "w"), link_port_(FreeUdpPort()) {
    fs::create_directories(workspace_.root());
  }

  static std::string Sibling(const std::string& name) {
    return (fs::path(COLMAP_EXT_PROGRAM).parent_path() / name).string();
  }

  void StartDrone() {
    drone_path_ = folder_ / "drone";
    drone_ =
        std::make_unique<BackgroundProgram>(std::vector<std::string>{Sibling("colmap_ext_dronesim"),
                                                                     "--scene",
                                                                     "boxes",
                                                                     "--texel_scale",
                                                                     "8",
                                                                     "--speed",
                                                                     "10",
                                                                     "--full_resolution",
                                                                     "0",
                                                                     "--connection",
                                                                     Connection("udpout"),
                                                                     "--output_path",
                                                                     drone_path_,
                                                                     "--Drone.failsafes",
                                                                     "safe",
                                                                     "--Drone.parameters",
                                                                     "RTL_RETURN_ALT=20",
                                                                     "--Drone.gps_bias_m",
                                                                     "0.05",
                                                                     "--Drone.gps_noise_m",
                                                                     "0.02"},
                                            folder_ / "drone.log");
    const auto is_ready = [&] { return drone_->Output().find('\n') != std::string::npos; };
    ASSERT_TRUE(drone_->WaitUntil(is_ready, 120)) << drone_->Output();
    const std::string output = drone_->Output();
    ready_ = json::parse(output.substr(0, output.find('\n')));
  }

  void StartDaemon(const std::vector<std::string>& more = {}) {
    fs::remove(workspace_.root() / "flightd.json");
    std::vector<std::string> arguments = {Sibling("colmap_ext_flightd"),
                                          "--workspace_path",
                                          workspace_.root().string(),
                                          "--connection",
                                          Connection("udpin"),
                                          "--simulated_speed",
                                          "10"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (std::find(more.begin(), more.end(), "--picture_url") == more.end()) {
      arguments.insert(
          arguments.end(),
          {"--picture_url", "http://127.0.0.1:" + std::to_string(ready_["http_port"].get<int>()) +
                                "/pictures/{resolution}/img_{index5}.jpg"});
    }
    daemon_ = std::make_unique<BackgroundProgram>(arguments, folder_ / "daemon.log");
    ASSERT_TRUE(
        daemon_->WaitUntil([&] { return fs::exists(workspace_.root() / "flightd.json"); }, 60))
        << daemon_->Output();
  }

  std::string Connection(const std::string& kind) const {
    return kind + "://127.0.0.1:" + std::to_string(link_port_);
  }

  // Above the room, a person vouches for it.
  fs::path WriteMission() const {
    json mission = {{"revision", 1},
                    {"origin", ready_["origin"]},
                    {"home_z_m", ready_["home"]["enu_m"][2]},
                    {"speed_m_s", 3},
                    {"vouched", true},
                    {"transit_z_m", 12},
                    {"at_end", "return"},
                    {"stops", json::array()}};
    for (int i = 0; i < kViews; ++i) {
      mission["stops"].push_back({{"position_enu_m", {2.0 * i - 4, -3, 10}},
                                  {"yaw_deg", 0},
                                  {"pitch_deg", -70},
                                  {"view_id", i},
                                  {"photo", "photo_" + std::to_string(i) + ".jpg"}});
    }
    const fs::path path = folder_ / "mission.json";
    WriteFileAtomically(path, mission.dump());
    return path;
  }

  ChildProcessResult Client(const std::string& action,
                            const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"flight_client", action, "--workspace_path",
                                          workspace_.root().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  std::string State() const {
    const std::string output = Client("status").output;
    return output.substr(0, output.find_first_of(":\n"));
  }
  void WaitForState(const std::set<std::string>& states, double timeout_s) {
    std::string state;
    EXPECT_TRUE(daemon_->WaitUntil(
        [&] {
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
          return states.contains(state = State());
        },
        timeout_s))
        << state << '\n'
        << daemon_->Output();
  }
  // The estimator is not ready at once: asks until it is.
  void Begin() {
    const fs::path mission = WriteMission();
    WaitForState({"IDENTIFIED"}, 60);
    ASSERT_EQ(Client("load", {"--mission_path", mission}).exit_code, 0);
    for (int i = 0; i < 60 && Records("start").empty(); ++i) {
      if (State() == "IDENTIFIED") Client("start", {"--yes", "1"});
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    ASSERT_FALSE(Records("start").empty()) << Client("status").output;
  }

  json DroneStatus() const {
    return json::parse(GetPictureByHttp(
        "http://127.0.0.1:" + std::to_string(ready_["http_port"].get<int>()) + "/status",
        HttpCallOptions()));
  }
  std::vector<json> Records(const std::string& type) const {
    const fs::path path = workspace_.root() / "flight" / "journal.jsonl";
    std::vector<json> records;
    std::istringstream lines(fs::exists(path) ? ReadFile(path) : "");
    for (std::string line; std::getline(lines, line);) {
      if (lines.eof()) break;
      json record = json::parse(line);
      if (record["type"] == type) records.push_back(std::move(record));
    }
    return records;
  }
  bool WaitForPhotos(std::size_t count) {
    return daemon_->WaitUntil(
        [&] {
          return fs::exists(workspace_.images()) && ListPhotos(workspace_.images()).size() >= count;
        },
        120);
  }
  void ExpectEveryViewStoredOnce() const {
    std::map<int, int> stored;
    for (const json& record : Records("stored")) ++stored[record["view"].get<int>()];
    EXPECT_EQ(stored.size(), static_cast<std::size_t>(kViews));
    for (const auto& [view, count] : stored) EXPECT_EQ(count, 1) << "view " << view;
    EXPECT_EQ(ListPhotos(workspace_.images()).size(), static_cast<std::size_t>(kViews));
  }

  Workspace workspace_;
  int link_port_;
  fs::path drone_path_;
  json ready_;
  std::unique_ptr<BackgroundProgram> drone_, daemon_;
};

TEST_F(FlightProgram, AClientLoadsChecksFliesPausesAndWatches) {
  ASSERT_NO_FATAL_FAILURE(StartDrone());
  ASSERT_NO_FATAL_FAILURE(StartDaemon());
  BackgroundProgram watch({COLMAP_EXT_PROGRAM, "flight_client", "watch", "--workspace_path",
                           workspace_.root().string()},
                          folder_ / "watch.log");
  ExpectFailure(Client("start", {"--yes", "1"}), 1, {"mission"});
  ExpectFailure(Client("resume"), 1, {"nothing to resume"});
  ASSERT_NO_FATAL_FAILURE(Begin());
  ASSERT_TRUE(WaitForPhotos(1));
  EXPECT_EQ(Client("pause").exit_code, 0);
  WaitForState({"PAUSED"}, 20);
  EXPECT_EQ(Client("resume").exit_code, 0);
  WaitForState({"DISARMED"}, 120);
  ExpectEveryViewStoredOnce();
  const std::string status = Client("status").output;
  EXPECT_NE(status.find("5 stored"), std::string::npos) << status;
  EXPECT_NE(status.find("good"), std::string::npos) << "the checks";
  EXPECT_TRUE(watch.WaitUntil(
      [&] { return watch.Output().find("\"to\":\"DISARMED\"") != std::string::npos; }, 20))
      << watch.Output();
  EXPECT_EQ(daemon_->Kill(SIGTERM), 0);
  EXPECT_EQ(watch.Wait(), 0) << "it ends with the daemon";
  ExpectFailure(Client("status"), 1, {"no flight daemon runs"});
}

TEST_F(FlightProgram, NobodySaysYesAndAbortReturns) {
  ASSERT_NO_FATAL_FAILURE(StartDrone());
  ASSERT_NO_FATAL_FAILURE(StartDaemon());
  WaitForState({"IDENTIFIED"}, 60);
  ASSERT_EQ(Client("load", {"--mission_path", WriteMission()}).exit_code, 0);
  const ChildProcessResult unasked = Client("start");  // its input is at its end
  ExpectFailure(unasked, 1, {"not started"});
  EXPECT_NE(unasked.output.find("Type yes"), std::string::npos);
  EXPECT_TRUE(Records("start").empty());
  ASSERT_NO_FATAL_FAILURE(Begin());
  ASSERT_TRUE(WaitForPhotos(1));
  EXPECT_EQ(Client("abort", {"--how", "land"}).exit_code, 0);
  WaitForState({"DISARMED"}, 120);
  EXPECT_TRUE(DroneStatus()["landed"]);
  EXPECT_LT(ListPhotos(workspace_.images()).size(), static_cast<std::size_t>(kViews));
}

TEST_F(FlightProgram, PicturesByMavlinkFtp) {
  ASSERT_NO_FATAL_FAILURE(StartDrone());
  ASSERT_NO_FATAL_FAILURE(
      StartDaemon({"--picture_url", "mftp://[;comp=100]/{resolution}/img_{index5}.jpg"}));
  ASSERT_NO_FATAL_FAILURE(Begin());
  WaitForState({"DISARMED"}, 180);
  ExpectEveryViewStoredOnce();
  for (const json& record : Records("capture")) {
    char name[32];
    std::snprintf(name, sizeof name, "img_%05d.jpg", record["index"].get<int>());
    EXPECT_EQ(ReadFile(workspace_.images() /
                       ("photo_" + std::to_string(record["view"].get<int>()) + ".jpg")),
              ReadFile(drone_path_ / "low" / name))
        << "byte for byte";
  }
}

TEST_F(FlightProgram, ShadowModeWatchesAndSendsNothing) {
  ASSERT_NO_FATAL_FAILURE(StartDrone());
  ASSERT_NO_FATAL_FAILURE(StartDaemon({"--shadow", "1"}));
  WaitForState({"IDENTIFIED"}, 60);
  ASSERT_EQ(Client("load", {"--mission_path", WriteMission()}).exit_code, 1);
  ExpectFailure(Client("start", {"--yes", "1"}), 1, {"shadow mode"});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const json commands = DroneStatus()["commands"];
  EXPECT_EQ(commands["motion"], 0) << commands;
  EXPECT_EQ(commands["arm"], 0) << commands;
  EXPECT_EQ(commands["capture"], 0) << commands;
  EXPECT_NE(Client("status").output.find("PX4"), std::string::npos) << "and knows the vehicle";
}

// kill -9 in the middle of missions: the vehicle is left alone until somebody says resume.
TEST_F(FlightProgram, AKilledDaemonMovesNothingAndLosesNothing) {
  ASSERT_NO_FATAL_FAILURE(StartDrone());
  ASSERT_NO_FATAL_FAILURE(StartDaemon());
  ASSERT_NO_FATAL_FAILURE(Begin());
  for (const std::size_t photos : {1U, 2U, 4U}) {
    ASSERT_TRUE(WaitForPhotos(photos)) << daemon_->Output();
    EXPECT_EQ(daemon_->Kill(SIGKILL), 128 + SIGKILL);
    const json before = DroneStatus()["commands"];
    ASSERT_NO_FATAL_FAILURE(StartDaemon());
    WaitForState({"PAUSED"}, 30);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_EQ(DroneStatus()["commands"]["motion"], before["motion"]);
    EXPECT_EQ(Client("resume").exit_code, 0) << Client("status").output;
  }
  WaitForState({"DISARMED"}, 180);
  ExpectEveryViewStoredOnce();
  EXPECT_LE(DroneStatus()["captures"], kViews + 3) << "at most what a kill left open";
}

}  // namespace
}  // namespace colmap_ext
