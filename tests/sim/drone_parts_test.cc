// Fence, parameters, faults, and what the failsafes do for each value of their parameters.
#include <gtest/gtest.h>

#include "autopilot_peer.h"
#include "colmap_ext/sim/drone_faults.h"
#include "colmap_ext/util/error.h"
#include "sim/drone_fence.h"
#include "sim/drone_parameters.h"

namespace colmap_ext {
namespace {

using test::AutopilotPeer;
using test::kPlace;
using test::QuietDrone;

MavMissionItemInt Corner(MavCmd command, double east, double north, double parameter) {
  const GeoPosition place = GeoFromEnu(kPlace, {east, north, 0});
  MavMissionItemInt item;
  item.command = command;
  item.param1 = static_cast<float>(parameter);
  item.x = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
  item.y = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
  return item;
}

// An L: the square of 20 m without its north-eastern quarter.
std::vector<MavMissionItemInt> LShape() {
  const auto command = MavCmd::kNavFencePolygonVertexInclusion;
  std::vector<MavMissionItemInt> items;
  for (const auto& [east, north] : {std::pair(0, 0), std::pair(20, 0), std::pair(20, 10),
                                    std::pair(10, 10), std::pair(10, 20), std::pair(0, 20)}) {
    items.push_back(Corner(command, east, north, 6));
  }
  return items;
}

TEST(DroneFence, PolygonsMayBeConcave) {
  DroneFence fence;
  EXPECT_TRUE(fence.IsEmpty());
  EXPECT_TRUE(fence.Contains({500, 500}, false)) << "without a fence everything is inside";
  fence.SetItems(LShape(), kPlace);
  EXPECT_TRUE(fence.Contains({5, 15}, false));
  EXPECT_TRUE(fence.Contains({15, 5}, false));
  EXPECT_FALSE(fence.Contains({15, 15}, false));
  EXPECT_FALSE(fence.Contains({-1, 5}, false));
}

TEST(DroneFence, ExclusionsAndCirclesCount) {
  auto items = LShape();
  items.push_back(Corner(MavCmd::kNavFenceCircleExclusion, 5, 5, 3));
  DroneFence fence;
  fence.SetItems(items, kPlace);
  EXPECT_FALSE(fence.Contains({5, 7}, false));
  EXPECT_TRUE(fence.Contains({5, 9}, false));
  // Two inclusions: ArduPilot wants both, PX4 one.
  items.push_back(Corner(MavCmd::kNavFenceCircleInclusion, 40, 5, 8));
  fence.SetItems(items, kPlace);
  EXPECT_FALSE(fence.Contains({5, 15}, false));
  EXPECT_TRUE(fence.Contains({5, 15}, true));
  EXPECT_TRUE(fence.Contains({41, 5}, true));
  EXPECT_FALSE(fence.Contains({60, 5}, true));
}

TEST(DroneParameters, SafeAndSingleValuesComeOnTopOfStock) {
  const DroneParameters stock(kPx4, "stock", ""), safe(kPx4, "safe", "RTL_RETURN_ALT=12.5");
  EXPECT_EQ(stock.GetInt("NAV_DLL_ACT"), 0);
  EXPECT_EQ(safe.GetInt("NAV_DLL_ACT"), 2);
  EXPECT_EQ(safe.Get("RTL_RETURN_ALT"), 12.5);
  for (const char* bad : {"RTL_RETURN_ALT=", "RTL_RETURN_ALT=1x", "=3", "RTL_RETURN_ALT=nan"}) {
    EXPECT_THROW(DroneParameters(kPx4, "stock", bad), UsageError) << bad;
  }
}

TEST(DroneFaults, ComeBackAsTheyWereSet) {
  DroneFaults faults;
  const DroneEvents events = ChangeFaults(
      R"({"loss": 0.2, "delay_s": 0.5, "camera_failed": "silent", "gimbal_stuck": true,
          "gps_glitch_m": -8, "pilot_mode": "LOITER", "battery_percent": 20})",
      &faults);
  EXPECT_EQ(events.pilot_mode, "LOITER");
  EXPECT_EQ(events.battery_percent, 20);
  EXPECT_FALSE(events.crash);
  DroneFaults again;
  ChangeFaults(ToJson(faults).dump(), &again);
  EXPECT_EQ(ToJson(again), ToJson(faults));
  EXPECT_EQ(again.camera, CameraFault::kSilent);
  EXPECT_EQ(again.link.loss, 0.2);
  EXPECT_THROW(ChangeFaults(R"({"loss": 0.9, "delay_s": -1})", &again), UsageError);
  EXPECT_EQ(again.link.loss, 0.2) << "all or nothing";
}

// The mode in which a PX4 or ArduPilot vehicle with `parameters` is, 15 s after its ground station
// fell silent.
std::string ModeAfterSilence(AutopilotPersonality personality, const std::string& parameters) {
  AutopilotOptions options = QuietDrone(personality);
  options.parameters = parameters;
  AutopilotPeer peer(options);
  EXPECT_TRUE(peer.GoUp(30));
  peer.keeps_heartbeat = false;
  peer.Run(15);
  return peer.Mode();
}

TEST(Failsafe, LossOfTheLinkDoesWhatItsParameterSays) {
  EXPECT_EQ(ModeAfterSilence(kPx4, "NAV_DLL_ACT=0"), "HOLD");
  EXPECT_EQ(ModeAfterSilence(kPx4, "NAV_DLL_ACT=1"), "HOLD");
  EXPECT_EQ(ModeAfterSilence(kPx4, "NAV_DLL_ACT=3"), "LAND");
  EXPECT_EQ(ModeAfterSilence(kPx4, "NAV_DLL_ACT=2,COM_DL_LOSS_T=30"), "HOLD") << "not yet";
  EXPECT_EQ(ModeAfterSilence(kArduPilot, "FS_GCS_ENABLE=5"), "LAND");
}

TEST(Failsafe, ALowBatteryDoesWhatItsParameterSays) {
  const auto mode_at = [](AutopilotPersonality personality, const std::string& parameters,
                          double percent) {
    AutopilotOptions options = QuietDrone(personality);
    options.parameters = parameters;
    AutopilotPeer peer(options);
    EXPECT_TRUE(peer.GoUp(20));
    peer.drone.SetBatteryPercent(percent);
    peer.Run(1);
    return peer.Mode();
  };
  EXPECT_EQ(mode_at(kPx4, "COM_LOW_BAT_ACT=0", 6), "HOLD");
  EXPECT_EQ(mode_at(kPx4, "COM_LOW_BAT_ACT=2", 6), "LAND");
  EXPECT_EQ(mode_at(kPx4, "COM_LOW_BAT_ACT=3", 12), "HOLD") << "low is only a warning";
  EXPECT_EQ(mode_at(kArduPilot, "BATT_LOW_MAH=2000", 20), "GUIDED");
  EXPECT_EQ(mode_at(kArduPilot, "BATT_LOW_MAH=2000,BATT_FS_LOW_ACT=1", 20), "LAND");
}

TEST(Heartbeat, ArduPilotTellsANewModeAtOnceAndPx4WithTheNextOne) {
  for (const auto personality : {kPx4, kArduPilot}) {
    AutopilotPeer peer(QuietDrone(personality));
    ASSERT_TRUE(peer.GoUp(5));
    const int before = peer.Count<MavHeartbeat>();
    ASSERT_TRUE(peer.RunUntil([&] { return peer.Count<MavHeartbeat>() > before; }, 2));
    const std::uint32_t mode = peer.Last<MavHeartbeat>()->custom_mode;
    peer.drone.PilotSwitch(peer.is_px4 ? "POSCTL" : "LOITER");
    peer.Run(0.1);
    EXPECT_EQ(peer.Last<MavHeartbeat>()->custom_mode == mode, peer.is_px4);
    peer.Run(1.1);
    EXPECT_NE(peer.Last<MavHeartbeat>()->custom_mode, mode);
  }
}

TEST(Arming, EndsByItselfOnTheGroundAndIsKeptInTheAir) {
  for (const auto personality : {kPx4, kArduPilot}) {
    AutopilotPeer peer(QuietDrone(personality));
    peer.Run(25);
    if (!peer.is_px4) {
      ASSERT_EQ(peer.SetMode(ArduCopterMode::kGuided), MavResult::kAccepted);
    }
    ASSERT_EQ(peer.Arm(), MavResult::kAccepted);
    peer.Run(9);
    EXPECT_TRUE(peer.drone.Truth().is_armed);
    peer.Run(3);
    EXPECT_FALSE(peer.drone.Truth().is_armed) << "nobody took off";
    ASSERT_TRUE(peer.GoUp(5));
    const std::array<float, 7> disarm = {0, 0, 0, 0, 0, 0, 0};
    EXPECT_NE(peer.Command(MavCmd::kComponentArmDisarm, disarm), MavResult::kAccepted);
    EXPECT_TRUE(peer.drone.Truth().is_armed);
    EXPECT_EQ(peer.Command(MavCmd::kComponentArmDisarm, {0, 21196, 0, 0, 0, 0, 0}),
              MavResult::kAccepted);
    peer.Run(4);
    EXPECT_TRUE(peer.drone.Truth().has_crashed) << "forced in the air, it falls";
  }
}

}  // namespace
}  // namespace colmap_ext
