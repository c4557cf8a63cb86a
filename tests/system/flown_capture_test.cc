// The main job with its flight: session, flight daemon and simulated drone as three processes.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "background_program.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/workspace.h"
#include "orbit_photos.h"
#include "session/flight_programs.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class FlownCaptureTest : public OrbitPhotos {
 protected:
  FlownCaptureTest() : workspace_(folder_ / "w") {}

  std::vector<std::string> Arguments(int iterations, int views = 28) const {
    return {COLMAP_EXT_PROGRAM,
            "active_capture",
            "--workspace_path",
            workspace_.root().string(),
            "--scene",
            "boxes",
            "--Session.max_iterations",
            std::to_string(iterations),
            "--InitialFlight.num_views",
            std::to_string(views),
            "--Session.pictures",
            "0"};
  }

  // Records of the flight journal of this type.
  std::vector<json> Records(const std::string& type) const {
    std::vector<json> records;
    std::istringstream lines(Journal());
    for (std::string line; std::getline(lines, line);) {
      if (lines.eof()) break;
      json record = json::parse(line);
      if (record["type"] == type) records.push_back(std::move(record));
    }
    return records;
  }
  std::string Journal() const {
    const fs::path path = workspace_.root() / "flight" / "journal.jsonl";
    return fs::exists(path) ? ReadFile(path) : "";
  }
  std::size_t CountPhotos() const {
    return fs::exists(workspace_.images()) ? ListPhotos(workspace_.images()).size() : 0;
  }
  bool HasChildren() const {
    return !FindProcesses("colmap_ext_flightd", workspace_.root()).empty() ||
           !FindProcesses("colmap_ext_dronesim", workspace_.root()).empty();
  }
  bool ChildrenEndSoon() const {
    for (int i = 0; i < 500 && HasChildren(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return !HasChildren();
  }
  json Summary() const { return json::parse(ReadFile(workspace_.summary_json())); }
  // Runs until so many photos are there.
  void RunUntil(BackgroundProgram* session, std::size_t photos) const {
    ASSERT_TRUE(session->WaitUntil([&] { return CountPhotos() >= photos; }, 300))
        << session->Output();
  }

  Workspace workspace_;
};

TEST_F(FlownCaptureTest, CoverageRisesByThreeProcesses) {
  BackgroundProgram session(Arguments(2), folder_ / "log");
  RunUntil(&session, 1);
  EXPECT_EQ(FindProcesses("colmap_ext_flightd", workspace_.root()).size(), 1U);
  EXPECT_EQ(FindProcesses("colmap_ext_dronesim", workspace_.root()).size(), 1U);
  ASSERT_EQ(session.Wait(), 0) << session.Output();
  EXPECT_FALSE(HasChildren());

  const json summary = Summary();
  EXPECT_EQ(summary["finished"], "iteration_limit");
  ASSERT_EQ(summary["iterations"].size(), 2U);
  EXPECT_EQ(summary["iterations"][0]["photos"], 28);
  EXPECT_EQ(summary["iterations"][0]["registered"], 28);
  EXPECT_GT(summary["iterations"][1]["registered"], 28);
  EXPECT_GT(summary["iterations"][1]["covered_ratio"], summary["iterations"][0]["covered_ratio"]);
  EXPECT_LT(summary["iterations"][1]["mean_error_m"], 0.2) << "of buildings 1.6 m high";

  const std::size_t photos = CountPhotos();
  EXPECT_EQ(Records("stored").size(), photos);
  EXPECT_EQ(Records("capture").size(), photos) << "every picture is one photo";
  EXPECT_EQ(ReadTruePoses(workspace_.root() / "truth" / "poses.txt").size(), photos);
  EXPECT_EQ(Records("state").back()["to"], "DISARMED") << "it flew home";
  EXPECT_NE(session.Output().find("in flight"), std::string::npos)
      << "photos are processed while the drone flies on";
}

TEST_F(FlownCaptureTest, ArduPilotFliesTheSameSession) {
  std::vector<std::string> arguments = Arguments(1, 12);
  arguments.insert(arguments.end(), {"--Session.personality", "ardupilot"});
  BackgroundProgram session(arguments, folder_ / "log");
  ASSERT_EQ(session.Wait(), 0) << session.Output();
  EXPECT_EQ(Summary()["iterations"][0]["photos"], 12);
  EXPECT_EQ(Records("state").back()["to"], "DISARMED");
}

// kill -9 of each of the three in turn; what is on disk counts, and nothing is photographed twice.
TEST_F(FlownCaptureTest, KilledSessionDaemonAndDroneLoseNoPhoto) {
  std::map<std::string, std::string> kept;
  const auto check_kept = [&] {
    for (const auto& [name, bytes] : kept) {
      EXPECT_EQ(ReadFile(workspace_.images() / name), bytes) << name << " was taken again";
    }
    for (const std::string& name : ListPhotos(workspace_.images())) {
      kept[name] = ReadFile(workspace_.images() / name);
    }
  };
  {
    BackgroundProgram session(Arguments(1), folder_ / "log");
    RunUntil(&session, 5);
    session.Kill(SIGKILL);
    EXPECT_TRUE(ChildrenEndSoon()) << "nobody outlives a killed session";
  }
  check_kept();
  {
    BackgroundProgram session(Arguments(1), folder_ / "log");
    RunUntil(&session, kept.size() + 5);
    const auto daemon = FindProcesses("colmap_ext_flightd", workspace_.root());
    ASSERT_EQ(daemon.size(), 1U);
    kill(daemon[0], SIGKILL);
    EXPECT_EQ(session.Wait(), 1);
    EXPECT_NE(session.Output().find("colmap_ext_flightd ended"), std::string::npos)
        << session.Output();
    EXPECT_TRUE(ChildrenEndSoon());
  }
  check_kept();
  {
    BackgroundProgram session(Arguments(1), folder_ / "log");
    RunUntil(&session, kept.size() + 5);
    const auto drone = FindProcesses("colmap_ext_dronesim", workspace_.root());
    ASSERT_EQ(drone.size(), 1U);
    kill(drone[0], SIGKILL);
    EXPECT_EQ(session.Wait(), 1);
    EXPECT_NE(session.Output().find("colmap_ext_dronesim ended"), std::string::npos)
        << session.Output();
    EXPECT_TRUE(ChildrenEndSoon());
  }
  check_kept();
  {
    BackgroundProgram session(Arguments(1), folder_ / "log");
    RunUntil(&session, kept.size() + 2);
    session.Kill(SIGINT);
    EXPECT_TRUE(ChildrenEndSoon()) << "Ctrl-C ends them, too";
  }
  check_kept();
  BackgroundProgram session(Arguments(1), folder_ / "log");
  ASSERT_EQ(session.Wait(), 0) << session.Output();
  check_kept();
  EXPECT_EQ(kept.size(), 28U);
  EXPECT_EQ(Summary()["iterations"][0]["registered"], 28);
  EXPECT_LT(Summary()["iterations"][0]["mean_error_m"], 0.2) << "true poses belong to their photos";
  EXPECT_EQ(ReadTruePoses(workspace_.root() / "truth" / "poses.txt").size(), 28U);
  std::map<int, int> stored;
  for (const json& record : Records("stored")) ++stored[record["view"].get<int>()];
  EXPECT_EQ(stored.size(), 28U);
  for (const auto& [view, count] : stored) EXPECT_EQ(count, 1) << "view " << view;
}

// A vehicle that somebody else runs, a person's photos first, and no truth.
class RealVehicle : public FlownCaptureTest {
 protected:
  static std::string Sibling(const std::string& name) {
    return (fs::path(COLMAP_EXT_PROGRAM).parent_path() / name).string();
  }
  std::vector<std::string> VehicleArguments(const std::string& connection) const {
    return {COLMAP_EXT_PROGRAM,
            "active_capture",
            "--workspace_path",
            workspace_.root().string(),
            "--image_path",
            (folder_ / "photos").string(),
            "--vehicle",
            connection,
            "--preset",
            "indoor",
            "--Session.pictures",
            "0",
            "--Session.max_iterations",
            "2"};
  }
  // The vehicle, which sends to this port; its HTTP port comes back.
  int StartVehicle(int link_port) {
    vehicle_ = std::make_unique<BackgroundProgram>(
        std::vector<std::string>{Sibling("colmap_ext_dronesim"), "--scene", "boxes", "--connection",
                                 "udpout://127.0.0.1:" + std::to_string(link_port), "--output_path",
                                 (folder_ / "vehicle").string(), "--speed", "10",
                                 "--full_resolution", "0", "--Drone.failsafes", "safe",
                                 "--Drone.parameters", "RTL_RETURN_ALT=20", "--Drone.gps_bias_m",
                                 "0.01", "--Drone.gps_noise_m", "0.003"},
        folder_ / "vehicle.log");
    const auto is_ready = [&] { return vehicle_->Output().find('\n') != std::string::npos; };
    EXPECT_TRUE(vehicle_->WaitUntil(is_ready, 120)) << vehicle_->Output();
    const std::string output = vehicle_->Output();
    return json::parse(output.substr(0, output.find('\n')))["http_port"];
  }

  std::unique_ptr<BackgroundProgram> vehicle_;
};

TEST_F(RealVehicle, AsksBeforeItArmsAndFliesWhereThePhotosLackOnesOfItsOwn) {
  RenderOrbit(folder_ / "photos", 0, 24);
  const int link_port = FreeUdpPort();
  const int http_port = StartVehicle(link_port);
  const std::string connection = "udpin://127.0.0.1:" + std::to_string(link_port);
  {
    BackgroundProgram session(VehicleArguments(connection), folder_ / "log", "no\n");
    EXPECT_EQ(session.Wait(), 1) << session.Output();
    for (const char* words :
         {"views", "batteries", "nearest obstacle", "Type yes", "not started"}) {
      EXPECT_NE(session.Output().find(words), std::string::npos) << words << session.Output();
    }
    EXPECT_TRUE(ChildrenEndSoon());
    EXPECT_TRUE(Records("start").empty()) << "nothing armed";
  }
  // A daemon of its own, as for a flight that outlives the session.
  BackgroundProgram daemon(
      {Sibling("colmap_ext_flightd"), "--workspace_path", workspace_.root().string(),
       "--connection", connection, "--simulated_speed", "10", "--picture_url",
       "http://127.0.0.1:" + std::to_string(http_port) + "/pictures/{resolution}/img_{index5}.jpg",
       "--Flight.settle_distance_m", "0.1", "--Flight.settle_speed_m_s", "0.1",
       "--Flight.takeoff_height_m", "0.5"},
      folder_ / "daemon.log");
  ASSERT_TRUE(daemon.WaitUntil([&] { return fs::exists(workspace_.root() / "flightd.json"); }, 60));
  std::vector<std::string> arguments = VehicleArguments(connection);
  arguments.insert(arguments.end(), {"--yes", "1"});
  BackgroundProgram session(arguments, folder_ / "log");
  ASSERT_EQ(session.Wait(), 0) << session.Output();
  EXPECT_TRUE(daemon.IsRunning()) << "it is not the session's";
  const json summary = Summary();
  ASSERT_EQ(summary["iterations"].size(), 2U);
  EXPECT_EQ(summary["iterations"][0]["photos"], 24);
  const std::size_t flown = Records("stored").size();
  EXPECT_GT(flown, 0U);
  EXPECT_EQ(summary["iterations"][1]["photos"], 24 + flown);
  EXPECT_GT(summary["iterations"][1]["registered"], 24);
  EXPECT_FALSE(summary["iterations"][1].contains("mean_error_m")) << "nobody knows the truth";
  EXPECT_FALSE(fs::exists(workspace_.root() / "truth"));
  EXPECT_EQ(ListPhotos(folder_ / "photos").size(), 24U) << "a person's photos are only read";
  EXPECT_EQ(Records("state").back()["to"], "DISARMED");
  EXPECT_EQ(daemon.Kill(SIGTERM), 0);
}

TEST_F(RealVehicle, DoesNotGoWithAScene) {
  ExpectFailure(Run({"active_capture", "--workspace_path", workspace_.root().string(), "--scene",
                     "boxes", "--vehicle", "udpin://127.0.0.1:14550"}),
                2, {"--image_path"});
  ExpectFailure(Run({"active_capture", "--workspace_path", workspace_.root().string(), "--scene",
                     "boxes", "--vehicle", "telepathy"}),
                2, {"telepathy"});
}

}  // namespace
}  // namespace colmap_ext
