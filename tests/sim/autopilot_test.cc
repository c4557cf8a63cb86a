#include "colmap_ext/sim/autopilot.h"

#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "autopilot_peer.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Eigen::Vector3d;
using test::AutopilotPeer;
using test::kPlace;
using test::QuietDrone;

class BothStacks : public ::testing::TestWithParam<AutopilotPersonality> {
 protected:
  AutopilotOptions options_ = QuietDrone(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Stacks, BothStacks, ::testing::Values(kPx4, kArduPilot),
                         [](const auto& info) { return info.param == kPx4 ? "Px4" : "ArduPilot"; });

TEST_P(BothStacks, TellsWhatItIsAtItsRates) {
  AutopilotPeer peer(options_);
  peer.Run(60);
  const auto heartbeat = peer.Last<MavHeartbeat>();
  ASSERT_TRUE(heartbeat.has_value());
  EXPECT_EQ(peer.Last<MavSysStatus>()->battery_remaining, 99);
  EXPECT_NEAR(peer.Count<MavGlobalPositionInt>(), peer.is_px4 ? 280 : 200, 10);
  EXPECT_NEAR(peer.Count<MavAttitude>(), 300, 5);
  EXPECT_NEAR(peer.Count<MavGpsRawInt>(), 120, 3);
  EXPECT_NEAR(peer.Count<MavHomePosition>(), peer.is_px4 ? 28 : 20, 3);
  EXPECT_EQ(peer.Count<MavEstimatorStatus>() > 0, peer.is_px4);
  EXPECT_EQ(peer.Count<MavEkfStatusReport>() > 0, !peer.is_px4);
  const auto home = peer.Last<MavHomePosition>();
  EXPECT_NEAR(home->latitude * 1e-7, kPlace.lat_deg, 1e-7);
  EXPECT_NEAR(home->altitude, 500'000, 30);
  const auto gps = peer.Last<MavGpsRawInt>();
  EXPECT_NEAR(gps->alt_ellipsoid - gps->alt, 47'400, 1);
  EXPECT_EQ(gps->fix_type, MavGpsFixType::k3dFix);
}

TEST_P(BothStacks, ChangesTheRateOfAMessage) {
  AutopilotPeer peer(options_);
  const float id = MavAttitude::kId;
  EXPECT_EQ(peer.Command(MavCmd::kSetMessageInterval, {id, 50'000, 0, 0, 0, 0, 0}),
            MavResult::kAccepted);
  peer.Run(1);
  const int before = peer.Count<MavAttitude>();
  peer.Run(10);
  EXPECT_NEAR(peer.Count<MavAttitude>() - before, 200, 3);
  peer.Command(MavCmd::kSetMessageInterval, {id, -1, 0, 0, 0, 0, 0});
  const int stopped = peer.Count<MavAttitude>();
  peer.Run(5);
  EXPECT_EQ(peer.Count<MavAttitude>(), stopped);
}

TEST_P(BothStacks, FliesAMissionOfTargetsAndComesHome) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.Last<MavExtendedSysState>()->landed_state, MavLandedState::kInAir);
  for (const Vector3d& goal : {Vector3d(20, 5, 12), Vector3d(-5, 15, 8)}) {
    ASSERT_EQ(peer.FlyTo(goal), MavResult::kAccepted);
    EXPECT_TRUE(peer.RunUntil([&] { return (peer.Position() - goal).norm() < 0.2; }, 40));
    const auto target = peer.Last<MavPositionTargetGlobalInt>();
    EXPECT_NEAR(static_cast<double>(target->alt), kPlace.height_m + goal.z(), 0.05);
  }
  ASSERT_EQ(peer.Command(MavCmd::kNavReturnToLaunch, {}), MavResult::kAccepted);
  EXPECT_TRUE(peer.RunUntil([&] { return !peer.drone.Truth().is_armed; }, 200));
  EXPECT_LT(peer.Position().norm(), 0.3);
  EXPECT_EQ(peer.Last<MavExtendedSysState>()->landed_state, MavLandedState::kOnGround);
  EXPECT_FALSE(peer.drone.Truth().has_crashed);
  EXPECT_LT(peer.drone.Truth().motion.impact_speed_m_s, 1);
}

TEST_P(BothStacks, HoversWhereItIsWhenTheLinkIsSilentAndFailsafesAreStock) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(8));
  peer.FlyTo({15, 0, 8});
  peer.keeps_heartbeat = false;
  peer.Run(60);
  EXPECT_LT((peer.Position() - Vector3d(15, 0, 8)).norm(), 0.2);
  EXPECT_EQ(peer.drone.Truth().failsafe, "");
}

TEST_P(BothStacks, ReturnsWhenTheGroundStationIsSilentAndDoesNotComeBack) {
  options_.failsafes = "safe";
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(8));
  peer.FlyTo({25, 0, 8});
  peer.Run(10);
  peer.keeps_heartbeat = false;
  const double silent_at_s = peer.time_s;
  ASSERT_TRUE(peer.RunUntil([&] { return peer.Mode() == "RTL"; }, 30));
  EXPECT_NEAR(peer.time_s - silent_at_s, peer.is_px4 ? 9.5 : 4, 1.2);
  EXPECT_EQ(peer.drone.Truth().failsafe, "link");
  peer.keeps_heartbeat = true;
  peer.Run(5);
  EXPECT_EQ(peer.Mode(), "RTL") << "heartbeats do not restore the mode";
  EXPECT_TRUE(peer.RunUntil([&] { return !peer.drone.Truth().is_armed; }, 200));
}

TEST_P(BothStacks, LowBatteryReturnsThenLands) {
  options_.failsafes = "safe";
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(10));
  peer.FlyTo({30, 0, 10});
  peer.Run(20);
  peer.drone.SetBatteryPercent(peer.is_px4 ? 6.5 : 14);
  peer.Run(1);
  EXPECT_EQ(peer.Mode(), "RTL");
  peer.drone.SetBatteryPercent(4);
  peer.Run(1);
  EXPECT_EQ(peer.Mode(), "LAND");
  EXPECT_EQ(peer.drone.Truth().failsafe, "battery");
}

TEST_P(BothStacks, WithoutAPositionItLands) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(6));
  peer.drone.SetGpsLost(true);
  peer.Run(8);
  EXPECT_EQ(peer.Mode(), "LAND");
  const std::uint16_t flags =
      peer.is_px4 ? peer.Last<MavEstimatorStatus>()->flags : peer.Last<MavEkfStatusReport>()->flags;
  EXPECT_EQ(flags & MavEstimatorFlag::kPositionHorizontalAbsolute, 0);
  EXPECT_NE(flags & MavEstimatorFlag::kConstantPositionMode, 0);
  EXPECT_TRUE(peer.RunUntil([&] { return !peer.drone.Truth().is_armed; }, 60));
}

TEST_P(BothStacks, AGpsGlitchShowsBeforeItMovesTheVehicle) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(10));
  peer.drone.SetGpsGlitch(12);
  peer.Run(3);
  const std::uint16_t flags =
      peer.is_px4 ? peer.Last<MavEstimatorStatus>()->flags : peer.Last<MavEkfStatusReport>()->flags;
  EXPECT_NE(flags & (peer.is_px4 ? MavEstimatorFlag::kPx4GpsGlitch
                                 : MavEstimatorFlag::kArduPilotGpsGlitching),
            0);
  EXPECT_GT(peer.Last<MavGpsRawInt>()->h_acc, 2000U);
  EXPECT_LT(peer.Position().head<2>().norm(), 0.5);
  peer.Run(30);
  EXPECT_NEAR(peer.Position().x(), -12, 1) << "then the estimate follows, and it flies away";
}

TEST_P(BothStacks, ThePilotTakesOver) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(10));
  peer.FlyTo({100, 0, 10});
  peer.Run(4);
  const std::uint32_t before = peer.Last<MavHeartbeat>()->custom_mode;
  peer.drone.PilotSwitch(peer.is_px4 ? "POSCTL" : "LOITER");
  peer.Run(10);
  EXPECT_NE(peer.Last<MavHeartbeat>()->custom_mode, before);
  EXPECT_LT(peer.Position().x(), 50) << "it stopped";
  EXPECT_LT(peer.drone.Truth().motion.velocity.norm(), 0.1);
  EXPECT_THROW(peer.drone.PilotSwitch("WARP"), UsageError);
  EXPECT_EQ(peer.drone.Truth().motion_commands, peer.is_px4 ? 2 : 3);
}

TEST_P(BothStacks, FallsWhenTheBatteryIsEmpty) {
  AutopilotPeer peer(options_);
  ASSERT_TRUE(peer.GoUp(15));
  peer.drone.SetBatteryPercent(0);
  peer.Run(5);
  EXPECT_TRUE(peer.drone.Truth().has_crashed);
  EXPECT_EQ(peer.Arm(), peer.is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed);
}

TEST_P(BothStacks, TheSameSeedFliesTheSame) {
  struct Flight {
    std::vector<MavFrame> frames;
    std::vector<ShutterEvent> pictures;
  };
  const auto fly = [&](std::uint64_t seed) {
    AutopilotOptions options = options_;
    options.seed = seed;
    options.motion.wind = {6, 90, 1};
    options.gps.gps_bias_m = 0.05;
    AutopilotPeer peer(options);
    EXPECT_TRUE(peer.GoUp(10));
    peer.FlyTo({10, 10, 12});
    peer.Run(20);
    peer.Command(MavCmd::kDoDigicamControl, {0, 0, 0, 0, 1, 0, 0});
    peer.Run(2);
    return Flight{peer.frames, peer.pictures};
  };
  const Flight a = fly(5), b = fly(5), c = fly(6);
  EXPECT_TRUE(a.frames == b.frames);
  EXPECT_FALSE(a.frames == c.frames);
  ASSERT_EQ(a.pictures.size(), 1U);
  EXPECT_EQ(a.pictures[0].position, b.pictures[0].position);
  EXPECT_NE(a.pictures[0].position, c.pictures[0].position);
}

TEST_P(BothStacks, ReadsAndWritesParameters) {
  AutopilotPeer peer(options_);
  MavParamRequestList list;
  list.target_system = 1;
  peer.Send(list);
  peer.Run(3);
  const auto last = peer.Last<MavParamValue>();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(peer.Count<MavParamValue>(), last->param_count);
  const char* name = peer.is_px4 ? "NAV_DLL_ACT" : "FS_GCS_ENABLE";
  MavParamSet set;
  set.target_system = 1;
  SetMavText(name, &set.param_id);
  set.param_type = MavParamType::kInt32;
  set.param_value = peer.is_px4 ? std::bit_cast<float>(std::int32_t{2}) : 2.0F;
  peer.Send(set);
  MavParamRequestRead read;
  read.target_system = 1;
  read.param_index = -1;
  SetMavText(name, &read.param_id);
  peer.last.erase(MavParamValue::kId);
  peer.Send(read);
  const auto value = peer.Last<MavParamValue>();
  ASSERT_TRUE(value.has_value());
  EXPECT_EQ(MavText(value->param_id), name);
  // PX4: the integer's bits; ArduPilot: its value.
  EXPECT_EQ(peer.is_px4 ? std::bit_cast<std::int32_t>(value->param_value)
                        : static_cast<std::int32_t>(value->param_value),
            2);
  SetMavText("NO_SUCH_ONE", &read.param_id);
  peer.last.erase(MavParamValue::kId);
  peer.Send(read);
  EXPECT_FALSE(peer.Last<MavParamValue>().has_value());
}

TEST_P(BothStacks, BadOptionsAreNamed) {
  const auto complaint = [&](auto change) {
    AutopilotOptions options = options_;
    change(options);
    return options.Check();
  };
  EXPECT_EQ(options_.Check(), "");
  EXPECT_NE(complaint([](auto& o) { o.failsafes = "none"; }).find("failsafes"), std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.gps.gps_noise_m = -1; }).find("gps_noise"),
            std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.file_url = "ftp"; }).find("file_url"), std::string::npos);
  options_.parameters = "NAV_DLL_ACT";
  EXPECT_THROW(AutopilotPeer{options_}, UsageError);
  options_.parameters = "NO_SUCH_ONE=1";
  EXPECT_THROW(AutopilotPeer{options_}, UsageError);
  EXPECT_THROW(ParsePersonality("inav"), UsageError);
}

}  // namespace
}  // namespace colmap_ext
