#include "colmap_ext/sim/drone_simulator.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <opencv2/core.hpp>
#include <thread>

#include "colmap_ext/mavlink/ftp_client.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/sim/drone_faults.h"
#include "colmap_ext/util/files.h"
#include "drone_client.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::ErrorOf;
using test::HttpExchange;
using test::HttpGetJson;
using test::ScratchFolder;
using test::UdpPeer;

// A drone over a cube on the ground, at 40 times the speed, on a thread of its own.
class DroneSimulatorTest : public ::testing::Test {
 protected:
  DroneSimulatorTest() : scene_(MakeScene()), site_(scene_), renderer_(scene_, RenderOptions()) {
    camera_options_.width = 160;
    camera_options_.height = 92;
    camera_options_.focal_px = 120;
    camera_options_.full_width = 320;
    camera_options_.full_height = 184;
    options_.speed = 40;
    options_.output_path = folder_ / "out";
    options_.connection = peer_.Url();
    options_.autopilot.prearm_ready_s = 1;
    options_.autopilot.estimator_ready_s = 4;
  }
  ~DroneSimulatorTest() override { Stop(); }

  static TexturedScene MakeScene() {
    TexturedScene scene = test::GroundScene(test::FlatMaterial(128));
    test::AddCube({-1, 3, 0}, 2, 0, 1, &scene);
    return scene;
  }

  void Start() {
    camera_.emplace(renderer_, scene_.origin, camera_options_);
    simulator_.emplace(
        &io_, options_, scene_.origin, site_.DefaultHome(), site_, *camera_,
        [this] { has_crashed_ = true; }, JobControl());
    port_ = simulator_->http_port();
    simulator_->Start();
    thread_ = std::thread([this] { io_.run(); });
    EXPECT_TRUE(peer_.Hears<MavHeartbeat>(10));
  }
  void Stop() {
    if (!thread_.joinable()) return;
    boost::asio::post(io_, [this] { simulator_.reset(); });
    thread_.join();
  }

  std::optional<MavResult> Command(MavCmd id, std::array<float, 7> p) {
    MavCommandLong command;
    command.target_system = command.target_component = 1;
    command.command = id;
    command.param1 = p[0];
    command.param2 = p[1];
    command.param3 = p[2];
    command.param4 = p[3];
    command.param5 = p[4];
    command.param6 = p[5];
    command.param7 = p[6];
    peer_.Send(command);
    std::optional<MavResult> result;
    peer_.ReadUntil(
        [&](const MavFrame& frame) {
          const auto ack = UnpackMav<MavCommandAck>(frame);
          if (ack && ack->command == id) result = ack->result;
          return result.has_value();
        },
        5);
    return result;
  }
  bool WaitForStatus(const std::function<bool(const Json&)>& is_so, double most_s = 20) {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::milliseconds(static_cast<int>(most_s * 1e3));
    while (std::chrono::steady_clock::now() < end) {
      if (is_so(HttpGetJson(port_, "/status"))) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  bool GoUp(float height_m) {
    if (!WaitForStatus([](const Json& s) { return s["time_s"] > 9; })) return false;
    if (Command(MavCmd::kComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}) != MavResult::kAccepted) {
      return false;
    }
    const float amsl = static_cast<float>(scene_.origin.height_m) + height_m;
    if (Command(MavCmd::kNavTakeoff, {0, 0, 0, NAN, NAN, NAN, amsl}) != MavResult::kAccepted) {
      return false;
    }
    return WaitForStatus([](const Json& s) { return s["mode"] == "HOLD" && !s["landed"]; });
  }

  TexturedScene scene_;
  DroneSite site_;
  Renderer renderer_;
  SimulatedCameraOptions camera_options_;
  std::optional<SimulatedCamera> camera_;
  ScratchFolder folder_{"drone"};
  UdpPeer peer_;
  DroneSimulatorOptions options_;
  boost::asio::io_context io_;
  std::optional<DroneSimulator> simulator_;
  std::thread thread_;
  int port_ = 0;
  std::atomic<bool> has_crashed_ = false;
};

TEST_F(DroneSimulatorTest, APictureFetchedIsTheOneRenderedAtTheTruePose) {
  Start();
  ASSERT_TRUE(GoUp(5));
  ASSERT_EQ(Command(MavCmd::kImageStartCapture, {0, 0, 1, 1, 0, 0, 0}), MavResult::kAccepted);
  ASSERT_TRUE(WaitForStatus([](const Json& s) { return s["captures"] == 1; }));
  const auto low = HttpExchange(port_, "GET", "/pictures/low/img_00000.jpg");
  const auto full = HttpExchange(port_, "GET", "/pictures/full/img_00000.jpg");
  EXPECT_EQ(low.status, 200);
  EXPECT_EQ(low.body, ReadFile(options_.output_path / "low" / "img_00000.jpg"));
  EXPECT_EQ(full.body, ReadFile(options_.output_path / "full" / "img_00000.jpg"));
  const Json list = HttpGetJson(port_, "/pictures");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["low"]["url"], "/pictures/low/img_00000.jpg");
  EXPECT_EQ(list[0]["low"]["ready"], true);
  const auto poses = ReadTruePoses(options_.output_path / "true_poses.txt");
  ASSERT_EQ(poses.size(), 1U);
  const Eigen::Vector3d center = CameraCenter(poses[0].cam_from_world);
  EXPECT_NEAR(center.z(), 5, 1.5);
  // The same picture from the pose in the file.
  PlannedView view;
  view.position = center;
  view.direction = ViewDirectionOf(poses[0].cam_from_world);
  const SimulatedCamera again(renderer_, scene_.origin, camera_options_);
  again.CapturePhoto(view, folder_ / "again.jpg");
  const cv::Mat expected = ReadPhoto((folder_ / "again.jpg").string());
  const cv::Mat got = ReadPhoto((options_.output_path / "low" / "img_00000.jpg").string());
  EXPECT_LT(cv::norm(expected, got, cv::NORM_INF), 4);
  EXPECT_EQ(HttpExchange(port_, "GET", "/pictures/low/img_00001.jpg").status, 404);
  EXPECT_EQ(HttpExchange(port_, "GET", "/pictures/low/../true_poses.txt").status, 404);
}

TEST_F(DroneSimulatorTest, APictureComesByMavlinkFtpToo) {
  Start();
  ASSERT_TRUE(GoUp(5));
  ASSERT_EQ(Command(MavCmd::kImageStartCapture, {0, 0, 1, 1, 0, 0, 0}), MavResult::kAccepted);
  ASSERT_TRUE(WaitForStatus([](const Json& s) { return s["captures"] == 1; }));
  const auto low = HttpExchange(port_, "GET", "/pictures/low/img_00000.jpg");
  // Some packets are lost, as on a radio.
  HttpExchange(port_, "POST", "/faults", R"({"loss": 0.1})");
  MavFtpClient client({}, 40);
  const auto now = [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  client.Download("/low/img_00000.jpg", now());
  while (client.Status() == MavFtpStatus::kRunning && now() < 20) {
    for (const MavFtpPayload& payload : client.TakeOutgoing()) {
      peer_.Send(EncodeMavFtp(payload, 1, MavComponent::kCamera));
    }
    peer_.ReadUntil(
        [&](const MavFrame& frame) {
          const auto message = UnpackMav<MavFileTransferProtocol>(frame);
          const auto payload = message ? DecodeMavFtp(*message) : std::nullopt;
          if (payload) client.Receive(*payload, now());
          return false;
        },
        0.02);
    client.Poll(now());
  }
  ASSERT_EQ(client.Status(), MavFtpStatus::kDone) << client.Failure();
  EXPECT_EQ(std::string(client.Data().begin(), client.Data().end()), low.body);
}

TEST_F(DroneSimulatorTest, TimeRunsAtItsSpeed) {
  Start();
  const double first = HttpGetJson(port_, "/status")["time_s"];
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const double second = HttpGetJson(port_, "/status")["time_s"];
  EXPECT_NEAR(second - first, 20, 6);
}

TEST_F(DroneSimulatorTest, FaultsAreSetOverHttp) {
  Start();
  const auto post = [&](const std::string& body) {
    return HttpExchange(port_, "POST", "/faults", body);
  };
  EXPECT_EQ(post(R"({"loss": 0.25, "wind_m_s": 6})").status, 200);
  const Json faults = HttpGetJson(port_, "/faults");
  EXPECT_EQ(faults["loss"], 0.25);
  EXPECT_EQ(faults["wind_m_s"], 6);
  for (const char* bad : {"", "[]", "{", R"({"loss": 2})", R"({"los": 0})", R"({"crash": 1})",
                          R"({"loss": 0.1, "pilot_mode": "WARP"})", R"({"camera_failed": "yes"})",
                          R"({"battery_percent": null})"}) {
    const auto answer = post(bad);
    EXPECT_EQ(answer.status, 400) << bad;
    EXPECT_NE(answer.body.find("error"), std::string::npos) << bad;
  }
  EXPECT_EQ(HttpGetJson(port_, "/faults")["loss"], 0.25) << "a bad request changes nothing";
  EXPECT_EQ(HttpExchange(port_, "POST", "/status", "{}").status, 405);
  EXPECT_EQ(HttpExchange(port_, "GET", "/nothing").status, 404);
  post(R"({"battery_percent": 33})");
  EXPECT_TRUE(WaitForStatus([](const Json& s) { return s["battery_percent"] < 33.1; }));
  post(R"({"crash": true})");
  EXPECT_TRUE(has_crashed_);
}

TEST_F(DroneSimulatorTest, ALostLinkIsSilentAndComesBack) {
  Start();
  HttpExchange(port_, "POST", "/faults", R"({"link_lost": true})");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  while (peer_.Hears<MavHeartbeat>(0.05)) {
  }
  EXPECT_FALSE(peer_.Hears<MavHeartbeat>(0.3)) << "twelve simulated seconds";
  HttpExchange(port_, "POST", "/faults", R"({"link_lost": false})");
  EXPECT_TRUE(peer_.Hears<MavHeartbeat>(5));
}

TEST_F(DroneSimulatorTest, ThePilotTakesOverByHttp) {
  Start();
  ASSERT_TRUE(GoUp(5));
  EXPECT_EQ(HttpExchange(port_, "POST", "/faults", R"({"pilot_mode": "POSCTL"})").status, 200);
  EXPECT_TRUE(WaitForStatus(
      [](const Json& s) { return s["mode"] == "POSCTL" && s["pilot_takeovers"] == 1; }));
}

TEST_F(DroneSimulatorTest, SpeaksSignedOnly) {
  WriteFileAtomically(folder_ / "key", std::string(64, 'a'));
  std::filesystem::permissions(folder_ / "key", std::filesystem::perms::owner_read);
  options_.signing_key_path = folder_ / "key";
  Start();
  bool is_signed = false;
  peer_.ReadUntil([&](const MavFrame& frame) { return is_signed = frame.signature.has_value(); },
                  5);
  EXPECT_TRUE(is_signed);
  EXPECT_EQ(Command(MavCmd::kRequestMessage, {148, 0, 0, 0, 0, 0, 0}), std::nullopt)
      << "what comes unsigned is not heard";
}

TEST_F(DroneSimulatorTest, WhatCannotBeOpenedIsNamed) {
  camera_.emplace(renderer_, scene_.origin, camera_options_);
  const auto open = [&] {
    DroneSimulator(
        &io_, options_, scene_.origin, site_.DefaultHome(), site_, *camera_, [] {}, JobControl());
  };
  options_.connection = "carrier pigeon";
  EXPECT_NE(ErrorOf(open), "");
  options_.connection = peer_.Url();
  options_.faults = "{]";
  EXPECT_NE(ErrorOf(open).find("JSON"), std::string::npos);
  options_.faults = "{}";
  options_.speed = 0;
  EXPECT_NE(ErrorOf(open).find("speed"), std::string::npos);
}

TEST(DroneSite, FindsAFreePlaceAndKnowsTheGround) {
  TexturedScene scene = test::GroundScene(test::FlatMaterial(128));
  test::AddCube({-3, -3, 0}, 6, 0, 1, &scene);
  const DroneSite site(scene);
  const Eigen::Vector3d home = site.DefaultHome();
  EXPECT_NEAR(home.z(), 0, 1e-6);
  EXPECT_GT(site.Clearance(home, 50), 5);
  EXPECT_LT(home.head<2>().norm(), 16);
  EXPECT_NEAR(site.Ground()({0, 0, 9}), 6, 1e-5) << "the roof";
  EXPECT_NEAR(site.Ground()({10, 0, 9}), 0, 1e-5);
  EXPECT_NEAR(site.OnSurface(1, 1).z(), 6, 1e-5);
  EXPECT_NE(ErrorOf([&] { site.OnSurface(500, 0); }), "");
}

}  // namespace
}  // namespace colmap_ext
