// Each difference between PX4 and ArduPilot that the daemon has to know, by packets.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "autopilot_peer.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {
namespace {

using Eigen::Vector3d;
using test::AutopilotPeer;
using test::kPlace;
using test::QuietDrone;

MavMissionItemInt FenceCorner(int seq, double east, double north, int corners) {
  const GeoPosition place = GeoFromEnu(kPlace, {east, north, 0});
  MavMissionItemInt item;
  item.target_system = item.target_component = 1;
  item.seq = static_cast<std::uint16_t>(seq);
  item.command = MavCmd::kNavFencePolygonVertexInclusion;
  item.param1 = static_cast<float>(corners);
  item.x = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
  item.y = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
  item.mission_type = MavMissionType::kFence;
  return item;
}

// A square of 30 m around home.
std::vector<MavMissionItemInt> Square() {
  return {FenceCorner(0, -15, -15, 4), FenceCorner(1, 15, -15, 4), FenceCorner(2, 15, 15, 4),
          FenceCorner(3, -15, 15, 4)};
}

// What a list's upload ends with. Which request messages came goes into `requests`.
std::optional<MavMissionResult> Upload(AutopilotPeer* peer,
                                       const std::vector<MavMissionItemInt>& items,
                                       std::multiset<std::uint32_t>* requests = nullptr) {
  MavMissionCount count;
  count.target_system = count.target_component = 1;
  count.count = static_cast<std::uint16_t>(items.size());
  count.mission_type = items.empty() ? MavMissionType::kFence : items[0].mission_type;
  peer->last.erase(MavMissionAck::kId);
  peer->Send(count);
  for (int i = 0; i < 100; ++i) {
    if (const auto ack = peer->Last<MavMissionAck>()) return ack->type;
    int wanted = -1;
    if (const auto request = peer->Last<MavMissionRequest>()) wanted = request->seq;
    if (const auto request = peer->Last<MavMissionRequestInt>()) wanted = request->seq;
    for (const std::uint32_t id : {MavMissionRequest::kId, MavMissionRequestInt::kId}) {
      if (peer->last.erase(id) > 0 && requests != nullptr) requests->insert(id);
    }
    if (wanted >= 0 && wanted < static_cast<int>(items.size())) {
      peer->Send(items[static_cast<std::size_t>(wanted)]);
    } else {
      peer->Run(0.1);
    }
  }
  return std::nullopt;
}

TEST(Px4, ModesAreMainAndSub) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.SetMode(Px4MainMode::kAuto, Px4AutoMode::kLand), MavResult::kAccepted);
  peer.Run(1.1);
  EXPECT_EQ(peer.Last<MavHeartbeat>()->custom_mode, 4U << 16U | 6U << 24U);
  EXPECT_EQ(peer.Last<MavHeartbeat>()->autopilot, MavAutopilot::kPx4);
  EXPECT_EQ(peer.SetMode(Px4MainMode::kNone, Px4AutoMode::kNone), MavResult::kDenied);
}

TEST(ArduPilot, ModesAreOneNumber) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  EXPECT_EQ(peer.SetMode(ArduCopterMode::kGuided), MavResult::kFailed) << "no position yet";
  peer.Run(25);
  EXPECT_EQ(peer.SetMode(ArduCopterMode::kGuided), MavResult::kAccepted);
  peer.Run(1.1);
  EXPECT_EQ(peer.Last<MavHeartbeat>()->custom_mode, 4U);
  EXPECT_EQ(peer.Last<MavHeartbeat>()->autopilot, MavAutopilot::kArduPilot);
}

TEST(Px4, TakeoffHeightIsAmsl) {
  AutopilotPeer peer(QuietDrone(kPx4));
  peer.Run(8);
  ASSERT_EQ(peer.Arm(), MavResult::kAccepted);
  EXPECT_EQ(peer.Command(MavCmd::kNavTakeoff, {0, 0, 0, NAN, NAN, NAN, 506}), MavResult::kAccepted);
  peer.Run(2);
  EXPECT_EQ(peer.Mode(), "TAKEOFF");
  peer.Run(15);
  EXPECT_NEAR(peer.Position().z(), 6, 0.1);
  EXPECT_EQ(peer.Mode(), "HOLD") << "when it is up";
}

TEST(ArduPilot, TakeoffHeightIsRelativeAndNeedsGuidedAndArmed) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  peer.Run(25);
  const std::array<float, 7> up = {0, 0, 0, 0, 0, 0, 6};
  EXPECT_EQ(peer.Command(MavCmd::kNavTakeoff, up), MavResult::kFailed);
  ASSERT_EQ(peer.SetMode(ArduCopterMode::kGuided), MavResult::kAccepted);
  EXPECT_EQ(peer.Command(MavCmd::kNavTakeoff, up), MavResult::kFailed) << "not armed";
  ASSERT_EQ(peer.Arm(), MavResult::kAccepted);
  EXPECT_EQ(peer.FlyTo({10, 0, 6}), MavResult::kAccepted);
  peer.Run(3);
  EXPECT_TRUE(peer.drone.Truth().is_landed) << "a target does not lift it off the ground";
  EXPECT_EQ(peer.Command(MavCmd::kNavTakeoff, up), MavResult::kAccepted);
  peer.Run(15);
  EXPECT_NEAR(peer.Position().z(), 6, 0.1);
  EXPECT_EQ(peer.Mode(), "GUIDED");
}

TEST(Px4, IgnoresTheFrameOfATarget) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_TRUE(peer.GoUp(10));
  peer.Reposition({5, 5, 0}, 508, MavCoordinateFrame::kGlobalRelativeAltInt);
  peer.Run(15);
  EXPECT_NEAR(peer.Position().z(), 8, 0.1) << "508 was taken as AMSL";
}

TEST(ArduPilot, HonoursTheFrameOfATarget) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  ASSERT_TRUE(peer.GoUp(10));
  peer.Reposition({5, 5, 0}, 508, MavCoordinateFrame::kGlobalInt);
  peer.Run(15);
  EXPECT_NEAR(peer.Position().z(), 8, 0.1);
  peer.Reposition({5, 5, 0}, 12, MavCoordinateFrame::kGlobalRelativeAltInt);
  peer.Run(15);
  EXPECT_NEAR(peer.Position().z(), 12, 0.1);
}

TEST(Px4, TurnsToATargetsYawInRadians) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_TRUE(peer.GoUp(10));
  peer.FlyTo({10, 0, 10}, 2.0);
  peer.Run(15);
  EXPECT_NEAR(peer.drone.Truth().motion.yaw_rad, 2.0, 0.02);
  EXPECT_EQ(peer.Command(MavCmd::kConditionYaw, {90, 0, 0, 0, 0, 0, 0}), MavResult::kUnsupported);
}

TEST(ArduPilot, IgnoresATargetsYawAndTurnsByCommand) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  ASSERT_TRUE(peer.GoUp(10));
  peer.FlyTo({20, 0, 10}, 2.0);
  peer.Run(15);
  EXPECT_NEAR(peer.drone.Truth().motion.yaw_rad, DegToRad(90), 0.05) << "into the flight, east";
  EXPECT_EQ(peer.Command(MavCmd::kConditionYaw, {200, 0, 0, 0, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(8);
  EXPECT_NEAR(peer.drone.Truth().motion.yaw_rad, DegToRad(-160), 0.02);
}

TEST(Px4, WithoutTheFlagATargetIsUnsupportedAndYetFlown) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.Reposition({6, 0, 0}, 510, MavCoordinateFrame::kGlobal, 0, 0),
            MavResult::kUnsupported);
  peer.Run(15);
  EXPECT_NEAR(peer.Position().x(), 6, 0.2);
  peer.drone.PilotSwitch("POSCTL");
  EXPECT_EQ(peer.Reposition({20, 0, 0}, 510, MavCoordinateFrame::kGlobal, 0, 0),
            MavResult::kUnsupported);
  peer.Run(10);
  EXPECT_NEAR(peer.Position().x(), 6, 0.2) << "not against the pilot";
  EXPECT_EQ(peer.Mode(), "POSCTL");
}

TEST(ArduPilot, WithoutTheFlagATargetIsDeniedToThePilotsMode) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  ASSERT_TRUE(peer.GoUp(10));
  peer.drone.PilotSwitch("LOITER");
  EXPECT_EQ(peer.Reposition({20, 0, 0}, 10, MavCoordinateFrame::kGlobalRelativeAltInt, 0, 0),
            MavResult::kDenied);
  EXPECT_EQ(peer.Mode(), "LOITER");
}

TEST(Px4, AcknowledgesATargetOutsideTheFenceAndStays) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_EQ(Upload(&peer, Square()), MavMissionResult::kAccepted);
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.FlyTo({40, 0, 10}), MavResult::kAccepted);
  peer.Run(10);
  EXPECT_LT(peer.Position().x(), 1);
  EXPECT_LT(std::abs(peer.Last<MavPositionTargetGlobalInt>()->lon_int * 1e-7 - kPlace.lon_deg),
            1e-5);
  EXPECT_EQ(peer.texts.back(), "Reposition is outside geofence");
  EXPECT_EQ(peer.FlyTo({10, 0, 10}), MavResult::kAccepted);
  peer.Run(10);
  EXPECT_NEAR(peer.Position().x(), 10, 0.2);
}

TEST(ArduPilot, RefusesATargetOutsideTheFenceAndIgnoresAStreamedOne) {
  AutopilotOptions options = QuietDrone(kArduPilot);
  options.failsafes = "safe";
  AutopilotPeer peer(options);
  ASSERT_EQ(Upload(&peer, Square()), MavMissionResult::kAccepted);
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.FlyTo({40, 0, 10}), MavResult::kFailed);
  MavSetPositionTargetGlobalInt target;
  target.target_system = 1;
  target.coordinate_frame = MavCoordinateFrame::kGlobalRelativeAltInt;
  target.type_mask = MavTargetIgnore::kVelocity | MavTargetIgnore::kAcceleration |
                     MavTargetIgnore::kYaw | MavTargetIgnore::kYawRate;
  const auto send_to = [&](const Vector3d& enu) {
    const GeoPosition place = GeoFromEnu(kPlace, enu);
    target.lat_int = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
    target.lon_int = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
    target.alt = static_cast<float>(enu.z());
    peer.Send(target);
    peer.Run(10);
  };
  send_to({40, 0, 10});
  EXPECT_LT(peer.Position().x(), 1);
  send_to({8, 0, 10});
  EXPECT_NEAR(peer.Position().x(), 8, 0.2);
}

TEST(ArduPilot, TheFenceIsOffInAStockVehicle) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  ASSERT_EQ(Upload(&peer, Square()), MavMissionResult::kAccepted);
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.FlyTo({40, 0, 10}), MavResult::kAccepted);
  EXPECT_EQ(peer.Command(MavCmd::kDoFenceEnable, {1, 0, 0, 0, 0, 0, 0}), MavResult::kAccepted);
  EXPECT_EQ(peer.FlyTo({40, 0, 10}), MavResult::kFailed);
}

TEST(Fence, ABreachReturnsTheVehicle) {
  for (const auto personality : {kPx4, kArduPilot}) {
    AutopilotOptions options = QuietDrone(personality);
    options.failsafes = "safe";
    if (personality == kPx4) options.parameters = "GF_ACTION=3";
    options.motion.wind = {0, 0, 0};
    AutopilotPeer peer(options);
    ASSERT_TRUE(peer.GoUp(10));
    peer.FlyTo({14, 0, 10});
    peer.Run(12);
    // The fence comes down upon it.
    auto fence = Square();
    for (auto& corner : fence) corner.y -= (corner.y - 85'000'000) / 2;
    ASSERT_EQ(Upload(&peer, fence), MavMissionResult::kAccepted);
    peer.Run(1);
    EXPECT_EQ(peer.Mode(), "RTL");
    EXPECT_EQ(peer.drone.Truth().failsafe, "fence");
    EXPECT_EQ(peer.Last<MavFenceStatus>()->breach_status, 1);
  }
}

TEST(Upload, Px4MixesItsRequestsAndArduPilotAsksInTheOldWay) {
  std::multiset<std::uint32_t> px4, copter;
  AutopilotPeer a(QuietDrone(kPx4)), b(QuietDrone(kArduPilot));
  EXPECT_EQ(Upload(&a, Square(), &px4), MavMissionResult::kAccepted);
  EXPECT_EQ(Upload(&b, Square(), &copter), MavMissionResult::kAccepted);
  EXPECT_EQ(px4.count(MavMissionRequest::kId), 2U);
  EXPECT_EQ(px4.count(MavMissionRequestInt::kId), 2U);
  EXPECT_EQ(copter.count(MavMissionRequest::kId), 4U);
  EXPECT_EQ(copter.count(MavMissionRequestInt::kId), 0U);
}

TEST(Upload, ComesBackAsItWasSentAndBadListsAreRefused) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_EQ(Upload(&peer, Square()), MavMissionResult::kAccepted);
  MavMissionRequestList list;
  list.target_system = list.target_component = 1;
  list.mission_type = MavMissionType::kFence;
  peer.Send(list);
  EXPECT_EQ(peer.Last<MavMissionCount>()->count, 4);
  for (int seq = 0; seq < 4; ++seq) {
    MavMissionRequestInt request;
    request.target_system = request.target_component = 1;
    request.seq = static_cast<std::uint16_t>(seq);
    request.mission_type = MavMissionType::kFence;
    peer.Send(request);
    const auto item = peer.Last<MavMissionItemInt>();
    EXPECT_EQ(item->seq, seq);
    EXPECT_EQ(item->x, Square()[static_cast<std::size_t>(seq)].x);
    EXPECT_EQ(item->param1, 4);
  }
  auto cut = Square();
  cut.pop_back();
  EXPECT_EQ(Upload(&peer, cut), MavMissionResult::kInvalidParam1);
  auto foreign = Square();
  foreign[1].command = MavCmd::kNavWaypoint;
  EXPECT_EQ(Upload(&peer, foreign), MavMissionResult::kUnsupported);
  peer.Send(list);
  EXPECT_EQ(peer.Last<MavMissionCount>()->count, 4) << "the good one is kept";
}

TEST(Upload, RequestsAreRepeatedAndGivenUp) {
  AutopilotPeer peer(QuietDrone(kPx4));
  MavMissionCount count;
  count.target_system = count.target_component = 1;
  count.count = 3;
  count.mission_type = MavMissionType::kFence;
  peer.Send(count);
  peer.Run(5);
  EXPECT_GT(peer.Count<MavMissionRequestInt>(), 5);
  EXPECT_EQ(peer.Last<MavMissionAck>()->type, MavMissionResult::kOperationCancelled);
}

TEST(ArduPilot, SaysThatItCouldArmLongBeforeItCan) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  const auto says_ready = [&] {
    const auto status = peer.Last<MavSysStatus>();
    return status && (status->onboard_control_sensors_health & MavSensor::kPrearmCheck) != 0;
  };
  ASSERT_TRUE(peer.RunUntil(says_ready, 20));
  const double says_at_s = peer.time_s;
  EXPECT_EQ(peer.Arm(), MavResult::kFailed);
  EXPECT_NE(peer.Last<MavEkfStatusReport>()->flags & MavEstimatorFlag::kConstantPositionMode, 0);
  ASSERT_TRUE(peer.RunUntil([&] { return peer.Arm() == MavResult::kAccepted; }, 40));
  EXPECT_NEAR(peer.time_s - says_at_s, 16, 2.5);
  peer.Run(1.1);
  const std::uint16_t flags = peer.Last<MavEkfStatusReport>()->flags;
  EXPECT_NE(flags & MavEstimatorFlag::kPositionHorizontalAbsolute, 0);
  EXPECT_EQ(flags & MavEstimatorFlag::kConstantPositionMode, 0);
}

TEST(Px4, TakesAPictureOncePerSequenceNumberAndReportsItFromTheCamera) {
  AutopilotOptions options = QuietDrone(kPx4);
  AutopilotPeer peer(options);
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 7, 0, 0, 0}), MavResult::kAccepted);
  EXPECT_EQ(peer.last.at(MavCommandAck::kId).component_id, MavComponent::kCamera);
  peer.Run(1);
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 7, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(1);
  EXPECT_EQ(peer.pictures.size(), 1U);
  ASSERT_EQ(peer.Count<MavCameraImageCaptured>(), 1);
  EXPECT_EQ(peer.last.at(MavCameraImageCaptured::kId).component_id, MavComponent::kCamera);
  EXPECT_EQ(MavText(peer.Last<MavCameraImageCaptured>()->file_url), "");
  EXPECT_EQ(peer.Last<MavCameraImageCaptured>()->image_index, 0);
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 8, 0, 0, 0}, 100),
            MavResult::kAccepted);
  peer.Run(1);
  EXPECT_EQ(peer.Last<MavCameraImageCaptured>()->image_index, 1);
  EXPECT_EQ(peer.Count<MavCameraFeedback>(), 0);
  // A report that got lost can be asked for again.
  EXPECT_EQ(peer.Command(MavCmd::kRequestMessage, {MavCameraImageCaptured::kId, 0, 0, 0, 0, 0, 0}),
            MavResult::kAccepted);
  EXPECT_EQ(peer.Last<MavCameraImageCaptured>()->image_index, 0);
  EXPECT_EQ(peer.Command(MavCmd::kRequestMessage, {MavCameraImageCaptured::kId, 9, 0, 0, 0, 0, 0}),
            MavResult::kDenied);
  EXPECT_EQ(peer.Command(MavCmd::kRequestMessage, {MavCameraCaptureStatus::kId, 0, 0, 0, 0, 0, 0}),
            MavResult::kAccepted);
  EXPECT_EQ(peer.Last<MavCameraCaptureStatus>()->image_count, 2);
}

TEST(ArduPilot, TakesAPicturePerCommandNotTooSoonAndReportsOnlyFeedback) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  ASSERT_TRUE(peer.GoUp(10));
  EXPECT_EQ(peer.Command(MavCmd::kDoDigicamControl, {0, 0, 0, 0, 1, 0, 0}), MavResult::kAccepted);
  peer.Run(1);
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 1, 0, 0, 0}), MavResult::kFailed);
  peer.Run(1.6);
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 1, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(3);
  EXPECT_EQ(peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, 1, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(3);
  EXPECT_EQ(peer.pictures.size(), 3U) << "the same number again is another picture";
  EXPECT_EQ(peer.Count<MavCameraFeedback>(), 3);
  EXPECT_EQ(peer.Last<MavCameraFeedback>()->img_idx, 2);
  EXPECT_EQ(peer.Count<MavCameraImageCaptured>(), 0);
}

TEST(Camera, ItsFaultsAreToldApart) {
  AutopilotPeer peer(QuietDrone(kPx4));
  ASSERT_TRUE(peer.GoUp(10));
  float sequence = 1;
  const auto shoot = [&] {
    const auto result = peer.Command(MavCmd::kImageStartCapture, {0, 0, 1, sequence++, 0, 0, 0});
    peer.Run(2);
    return result;
  };
  peer.drone.SetCameraFault(CameraFault::kRefuses);
  EXPECT_EQ(shoot(), MavResult::kFailed);
  peer.drone.SetCameraFault(CameraFault::kSilent);
  EXPECT_EQ(shoot(), MavResult::kAccepted);
  EXPECT_EQ(peer.Count<MavCameraImageCaptured>(), 0);
  peer.drone.SetCameraFault(CameraFault::kReports);
  EXPECT_EQ(shoot(), MavResult::kAccepted);
  EXPECT_EQ(peer.Last<MavCameraImageCaptured>()->capture_result, 0);
  peer.drone.SetCameraFault(CameraFault::kNone);
  EXPECT_EQ(shoot(), MavResult::kAccepted);
  EXPECT_EQ(peer.Last<MavCameraImageCaptured>()->capture_result, 1);
  EXPECT_EQ(peer.pictures.size(), 1U);
}

TEST(Gimbal, ArduPilotRefusesNaNAndTakesZeros) {
  AutopilotPeer peer(QuietDrone(kArduPilot));
  const auto aim = MavCmd::kDoGimbalManagerPitchyaw;
  EXPECT_EQ(peer.Command(aim, {-30, 0, NAN, NAN, 0, 0, 0}), MavResult::kDenied);
  EXPECT_EQ(peer.Command(aim, {-30, 0, 0, 0, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(2);
  EXPECT_NEAR(RadToDeg(peer.drone.Truth().gimbal_pitch_rad), -30, 1e-6);
}

TEST(Gimbal, Px4ListensOnlyToWhoTookControl) {
  AutopilotPeer peer(QuietDrone(kPx4));
  const auto aim = MavCmd::kDoGimbalManagerPitchyaw;
  EXPECT_EQ(peer.Command(aim, {-40, 0, NAN, NAN, 0, 0, 0}), MavResult::kDenied);
  EXPECT_EQ(peer.Command(MavCmd::kDoGimbalManagerConfigure, {255, 190, -1, -1, 0, 0, 0}),
            MavResult::kAccepted);
  EXPECT_EQ(peer.Last<MavGimbalManagerStatus>()->primary_control_sysid, 255);
  EXPECT_EQ(peer.Command(aim, {-40, 0, NAN, NAN, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(2);
  EXPECT_NEAR(RadToDeg(peer.drone.Truth().gimbal_pitch_rad), -40, 1e-5);
  // 285: a quaternion whose pitch is that.
  const auto q = peer.Last<MavGimbalDeviceAttitudeStatus>()->q;
  EXPECT_NEAR(2 * std::atan2(static_cast<double>(q[2]), static_cast<double>(q[0])), DegToRad(-40),
              1e-4);
  peer.drone.SetGimbalStuck(true);
  EXPECT_EQ(peer.Command(aim, {0, 0, NAN, NAN, 0, 0, 0}), MavResult::kAccepted);
  peer.Run(2);
  EXPECT_NEAR(RadToDeg(peer.drone.Truth().gimbal_pitch_rad), -40, 1e-5);
  EXPECT_NE(peer.Last<MavGimbalDeviceAttitudeStatus>()->failure_flags, 0U);
}

TEST(Gimbal, AnOldOneKnowsMountControlOnly) {
  for (const auto personality : {kPx4, kArduPilot}) {
    AutopilotOptions options = QuietDrone(personality);
    options.gimbal_protocol = "mount";
    AutopilotPeer peer(options);
    EXPECT_EQ(peer.Command(MavCmd::kDoGimbalManagerPitchyaw, {-30, 0, 0, 0, 0, 0, 0}),
              MavResult::kUnsupported);
    EXPECT_EQ(peer.Command(MavCmd::kDoMountControl, {-25, 0, 0, 0, 0, 0, 2}), MavResult::kAccepted);
    peer.Run(2);
    const double pitch_deg = peer.is_px4
                                 ? static_cast<double>(peer.Last<MavMountOrientation>()->pitch)
                                 : peer.Last<MavMountStatus>()->pointing_a * 0.01;
    EXPECT_NEAR(pitch_deg, -25, 0.01);
    EXPECT_EQ(peer.Count<MavGimbalDeviceAttitudeStatus>(), 0);
  }
}

TEST(Signing, ArduPilotTakesAKeyUnlessItIsArmed) {
  MavSetupSigning setup;
  setup.target_system = setup.target_component = 1;
  setup.secret_key.fill(7);
  AutopilotPeer copter(QuietDrone(kArduPilot));
  copter.Send(setup);
  EXPECT_EQ(copter.drone.TakeSigningKey().size(), 32U);
  ASSERT_TRUE(copter.GoUp(5));
  copter.Send(setup);
  EXPECT_TRUE(copter.drone.TakeSigningKey().empty());
  AutopilotPeer px4(QuietDrone(kPx4));
  px4.Send(setup);
  EXPECT_TRUE(px4.drone.TakeSigningKey().empty());
}

}  // namespace
}  // namespace colmap_ext
