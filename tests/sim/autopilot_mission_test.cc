// Missions that were uploaded, as the exporters write them.
#include <gtest/gtest.h>

#include <cmath>

#include "autopilot_peer.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {
namespace {

using Eigen::Vector3d;
using test::AutopilotPeer;
using test::kPlace;
using test::QuietDrone;

class MissionTest : public ::testing::TestWithParam<AutopilotPersonality> {
 protected:
  MissionTest() : peer_(QuietDrone(GetParam())) {
    // ArduPilot keeps home in the first place.
    if (!peer_.is_px4) Add(MavCmd::kNavWaypoint, {0, 0, 0, 0}, {0, 0, 0});
  }

  void Add(MavCmd command, std::array<float, 4> p, const Vector3d& enu = Vector3d::Zero()) {
    const GeoPosition place = GeoFromEnu(kPlace, enu);
    MavMissionItemInt item;
    item.target_system = item.target_component = 1;
    item.seq = static_cast<std::uint16_t>(items_.size());
    item.frame = MavCoordinateFrame::kGlobalRelativeAltInt;
    item.command = command;
    item.autocontinue = 1;
    item.param1 = p[0];
    item.param2 = p[1];
    item.param3 = p[2];
    item.param4 = p[3];
    item.x = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
    item.y = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
    item.z = static_cast<float>(enu.z());
    items_.push_back(item);
  }

  MavMissionResult Upload() {
    MavMissionCount count;
    count.target_system = count.target_component = 1;
    count.count = static_cast<std::uint16_t>(items_.size());
    peer_.last.erase(MavMissionAck::kId);
    peer_.Send(count);
    // Everything is sent twice and out of order now and then, as on a bad link.
    for (int i = 0; i < 200 && !peer_.Last<MavMissionAck>(); ++i) {
      peer_.Send(items_[static_cast<std::size_t>(i / 2) % items_.size()]);
    }
    const auto ack = peer_.Last<MavMissionAck>();
    return ack ? ack->type : MavMissionResult::kError;
  }

  bool Start() {
    peer_.Run(peer_.is_px4 ? 8 : 25);
    if (!peer_.is_px4) {
      // Armed in GUIDED, taken off, then AUTO.
      if (!peer_.GoUp(6)) return false;
      return peer_.Command(MavCmd::kMissionStart, {}) == MavResult::kAccepted;
    }
    return peer_.Command(MavCmd::kMissionStart, {}) == MavResult::kAccepted &&
           peer_.Arm() == MavResult::kAccepted;
  }

  AutopilotPeer peer_;
  std::vector<MavMissionItemInt> items_;
};
INSTANTIATE_TEST_SUITE_P(Stacks, MissionTest, ::testing::Values(kPx4, kArduPilot),
                         [](const auto& info) { return info.param == kPx4 ? "Px4" : "ArduPilot"; });

TEST_P(MissionTest, TakesItsPicturesAndReturns) {
  if (peer_.is_px4) Add(MavCmd::kNavTakeoff, {0, 0, 0, NAN}, {0, 0, 6});
  const Vector3d views[] = {{12, 0, 8}, {12, 12, 9}};
  float pitch = -20;
  for (const Vector3d& view : views) {
    Add(MavCmd::kDoMountControl, {pitch, 0, 0, 0});
    Add(MavCmd::kNavWaypoint, {2, 1, 0, 90}, view);
    Add(MavCmd::kImageStartCapture, {0, 0, 1, 0});
    Add(MavCmd::kNavDelay, {3, 0, 0, 0});
    pitch -= 20;
  }
  Add(MavCmd::kNavReturnToLaunch, {});
  ASSERT_EQ(Upload(), MavMissionResult::kAccepted);
  ASSERT_TRUE(Start());
  ASSERT_TRUE(peer_.RunUntil([&] { return !peer_.drone.Truth().is_armed; }, 300));
  ASSERT_EQ(peer_.pictures.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT((peer_.pictures[i].position - views[i]).norm(), 1.0) << i;
    EXPECT_NEAR(RadToDeg(peer_.pictures[i].direction.pitch_rad), i == 0 ? -20 : -40, 1) << i;
  }
  // PX4 turns to the waypoint's heading; ArduPilot looks where it flew: north to the second one.
  const double heading = RadToDeg(peer_.pictures[1].direction.yaw_rad);
  EXPECT_NEAR(heading, peer_.is_px4 ? 90 : 0, 14);
  EXPECT_LT(peer_.Position().norm(), 0.5);
  EXPECT_GE(peer_.Count<MavMissionItemReached>(), 8);
}

TEST_P(MissionTest, GoesOnWhereItWasPaused) {
  if (peer_.is_px4) Add(MavCmd::kNavTakeoff, {0, 0, 0, NAN}, {0, 0, 6});
  Add(MavCmd::kNavWaypoint, {0, 1, 0, NAN}, {10, 0, 8});
  Add(MavCmd::kNavWaypoint, {0, 1, 0, NAN}, {30, 0, 8});
  Add(MavCmd::kNavLand, {});
  ASSERT_EQ(Upload(), MavMissionResult::kAccepted);
  ASSERT_TRUE(Start());
  ASSERT_TRUE(peer_.RunUntil([&] { return peer_.Position().x() > 14; }, 60));
  peer_.drone.PilotSwitch(peer_.is_px4 ? "HOLD" : "GUIDED");
  peer_.Run(10);
  const double paused_at = peer_.Position().x();
  EXPECT_LT(paused_at, 29);
  EXPECT_EQ(peer_.Last<MavMissionCurrent>()->mission_state, MavMissionState::kPaused);
  ASSERT_EQ(peer_.Command(MavCmd::kMissionStart, {}), MavResult::kAccepted);
  ASSERT_TRUE(peer_.RunUntil([&] { return peer_.Mode() == "LAND"; }, 60));
  EXPECT_NEAR(peer_.Position().x(), 30, 2.5);
}

TEST_P(MissionTest, WithoutOneThereIsNothingToStart) {
  peer_.Run(peer_.is_px4 ? 8 : 25);
  EXPECT_EQ(peer_.Command(MavCmd::kMissionStart, {}),
            peer_.is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed);
  EXPECT_EQ(peer_.Last<MavMissionCurrent>()->mission_state,
            peer_.is_px4 ? MavMissionState::kNoMission : MavMissionState::kNotStarted);
}

TEST_P(MissionTest, ArduPilotKeepsHomeInTheFirstPlace) {
  peer_.Run(25);
  Add(MavCmd::kNavWaypoint, {0, 0, 0, 0}, {10, 0, 8});
  Add(MavCmd::kNavWaypoint, {0, 0, 0, 0}, {20, 0, 8});
  items_[0].z = 77;
  ASSERT_EQ(Upload(), MavMissionResult::kAccepted);
  MavMissionRequestInt request;
  request.target_system = request.target_component = 1;
  peer_.Send(request);
  const float z = peer_.Last<MavMissionItemInt>()->z;
  EXPECT_NEAR(z, peer_.is_px4 ? 77 : 500, 0.1);
}

}  // namespace
}  // namespace colmap_ext
