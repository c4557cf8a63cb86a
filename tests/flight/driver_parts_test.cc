// Parts of the driver: commands with answers, the daemon's clock, checks before arming, messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "colmap_ext/flight/dry_run.h"
#include "colmap_ext/flight/plan_mission.h"
#include "colmap_ext/flight/preflight.h"
#include "colmap_ext/flight/segment_checks.h"
#include "flight/autopilot_dialect.h"
#include "flight/command_sender.h"
#include "flight/daemon_clock.h"
#include "flight/picture_fetch.h"
#include "flight/telemetry.h"

namespace colmap_ext {
namespace {

MavStep Step(MavCmd command, int tries = 3) {
  MavCommandLong message;
  message.command = command;
  MavStep step;
  step.message = message;
  step.tries = tries;
  return step;
}

MavCommandAck Ack(MavCmd command, MavResult result) {
  MavCommandAck ack;
  ack.command = command;
  ack.result = result;
  return ack;
}

TEST(CommandSender, RepeatsWithAGrowingConfirmationAndGivesUp) {
  CommandSender sender;
  sender.Start(1, CommandKind::kArm, {Step(MavCmd::kComponentArmDisarm)}, 0);
  std::vector<int> confirmations;
  for (double now = 0; now < 3; now += 0.1) {
    sender.Tick(now);
    sender.ReleaseMotion(now, now);
    for (const auto& message : sender.TakeMessages()) {
      confirmations.push_back(std::get<MavCommandLong>(message).confirmation);
    }
  }
  EXPECT_EQ(confirmations, (std::vector{0, 1, 2}));
  const auto results = sender.TakeResults();
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].outcome, CommandOutcome::kNoAnswer);
}

TEST(CommandSender, StepsFollowEachOther) {
  CommandSender sender;
  sender.Start(1, CommandKind::kGoTo, {Step(MavCmd::kDoReposition), Step(MavCmd::kConditionYaw)},
               0);
  sender.ReleaseMotion(0, 0);
  EXPECT_EQ(sender.TakeMessages().size(), 1U);
  sender.OnAck(Ack(MavCmd::kConditionYaw, MavResult::kAccepted), 0.1);
  EXPECT_TRUE(sender.TakeMessages().empty()) << "an answer to something else";
  sender.OnAck(Ack(MavCmd::kDoReposition, MavResult::kAccepted), 0.1);
  sender.ReleaseMotion(0.1, 0.1);
  EXPECT_EQ(sender.TakeMessages().size(), 1U);
  EXPECT_TRUE(sender.TakeResults().empty());
  sender.OnAck(Ack(MavCmd::kConditionYaw, MavResult::kAccepted), 0.2);
  EXPECT_EQ(sender.TakeResults().at(0).outcome, CommandOutcome::kAccepted);
}

TEST(CommandSender, TheSameCommandNumberWaits) {
  CommandSender sender;
  sender.Start(1, CommandKind::kPreflight, {Step(MavCmd::kDoSetMode)}, 0);
  sender.Start(2, CommandKind::kHold, {Step(MavCmd::kDoSetMode)}, 0);
  EXPECT_EQ(sender.TakeMessages().size(), 1U);
  sender.OnAck(Ack(MavCmd::kDoSetMode, MavResult::kFailed), 0.1);
  EXPECT_EQ(sender.TakeResults().at(0).outcome, CommandOutcome::kRejected);
  sender.ReleaseMotion(0.1, 0.1);
  EXPECT_EQ(sender.TakeMessages().size(), 1U) << "now the second";
}

TEST(CommandSender, TakesTheOlderCommandWhereTheNewOneIsUnknown) {
  CommandSender sender;
  MavStep step = Step(MavCmd::kImageStartCapture);
  step.otherwise = {Step(MavCmd::kDoDigicamControl)};
  sender.Start(1, CommandKind::kCapture, {step}, 0);
  sender.TakeMessages();
  sender.OnAck(Ack(MavCmd::kImageStartCapture, MavResult::kUnsupported), 0.1);
  const auto messages = sender.TakeMessages();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(std::get<MavCommandLong>(messages[0]).command, MavCmd::kDoDigicamControl);
  sender.OnAck(Ack(MavCmd::kDoDigicamControl, MavResult::kAccepted), 0.2);
  EXPECT_TRUE(sender.TakeResults().at(0).took_fallback);
}

TEST(CommandSender, OnlyTheLastWordOnTheWayIsRepeated) {
  CommandSender sender;
  sender.Start(1, CommandKind::kGuided, {Step(MavCmd::kDoSetMode)}, 0);
  sender.Start(2, CommandKind::kTakeoff, {Step(MavCmd::kNavTakeoff)}, 0.1);
  sender.ReleaseMotion(0.1, 0.1);
  sender.TakeMessages();
  sender.ReleaseMotion(5, 5);
  const auto messages = sender.TakeMessages();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(std::get<MavCommandLong>(messages[0]).command, MavCmd::kNavTakeoff);
}

TEST(CommandSender, InProgressWaitsLonger) {
  CommandSender sender;
  sender.Start(1, CommandKind::kArm, {Step(MavCmd::kComponentArmDisarm)}, 0);
  sender.ReleaseMotion(0, 0);
  sender.TakeMessages();
  sender.OnAck(Ack(MavCmd::kComponentArmDisarm, MavResult::kInProgress), 0.1);
  sender.ReleaseMotion(2, 2);
  EXPECT_TRUE(sender.TakeMessages().empty());
}

TEST(CommandSender, CancelledMotionIsNotRepeated) {
  CommandSender sender;
  sender.Start(1, CommandKind::kGoTo, {Step(MavCmd::kDoReposition)}, 0);
  sender.Start(2, CommandKind::kAskCamera, {Step(MavCmd::kRequestMessage)}, 0);
  sender.TakeMessages();
  sender.CancelMotion();
  sender.Tick(10);
  sender.ReleaseMotion(10, 10);
  const auto messages = sender.TakeMessages();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(std::get<MavCommandLong>(messages[0]).command, MavCmd::kRequestMessage);
}

TEST(CommandSender, MotionWaitsForAModeThatWasHeardAfterTheWish) {
  CommandSender sender;
  sender.Start(1, CommandKind::kGoTo, {Step(MavCmd::kDoReposition)}, 1);
  sender.Start(2, CommandKind::kCapture, {Step(MavCmd::kImageStartCapture)}, 1);
  ASSERT_EQ(sender.TakeMessages().size(), 1U) << "a picture moves nothing";
  sender.OnAck(Ack(MavCmd::kImageStartCapture, MavResult::kAccepted), 1.05);
  sender.ReleaseMotion(0.9, 1.1);
  EXPECT_TRUE(sender.TakeMessages().empty()) << "who knows what the mode is since";
  sender.ReleaseMotion(1.2, 1.2);
  EXPECT_EQ(sender.TakeMessages().size(), 1U);
  sender.ReleaseMotion(1.3, 3);
  EXPECT_TRUE(sender.TakeMessages().empty()) << "nor is it repeated without asking";
  sender.ReleaseMotion(3, 3);
  EXPECT_EQ(sender.TakeMessages().size(), 1U);
}

TEST(DaemonClock, FollowsTheWallWithoutASimulator) {
  DaemonClock clock(0);
  EXPECT_EQ(clock.Now(5), 5);
  clock.OnVehicleTime(1000, 6);
  EXPECT_EQ(clock.Now(7), 7);
}

TEST(DaemonClock, FollowsTheSimulatorAndStopsWithIt) {
  DaemonClock clock(20);
  double before = clock.Now(0);
  clock.OnVehicleTime(10, 0.1);
  const double start = clock.Now(0.1);
  for (int i = 1; i <= 20; ++i) {
    clock.OnVehicleTime(10 + 0.2 * i, 0.1 + 0.01 * i);
    const double now = clock.Now(0.1 + 0.01 * i);
    EXPECT_GE(now, before);
    before = now;
  }
  EXPECT_NEAR(clock.Now(0.3) - start, 4, 0.01);
  EXPECT_NEAR(clock.Now(2.3) - start, 4 + DaemonClock::kAheadS, 0.01) << "two seconds of silence";
  EXPECT_GT(clock.Now(5) - start, 4 + 20) << "nobody is there any more";
}

TEST(DaemonClock, DoesNotGoBackWhenTheSimulatorStartsAgain) {
  DaemonClock clock(10);
  clock.OnVehicleTime(500, 1);
  const double before = clock.Now(1);
  clock.OnVehicleTime(2, 2);
  EXPECT_GE(clock.Now(2), before);
  clock.OnVehicleTime(3, 2.1);
  EXPECT_NEAR(clock.Now(2.1) - clock.Now(2.05), 0.5, 0.6);
}

VehicleState GoodVehicle(AutopilotStack stack) {
  VehicleState vehicle;
  vehicle.stack = stack;
  vehicle.gps_fix = 3;
  vehicle.sigma_horizontal_m = 1;
  vehicle.is_estimate_good = true;
  vehicle.home = GeoPosition{47, 8, 400};
  vehicle.battery_percent = 95;
  return vehicle;
}

FlightMission GoodMission() {
  FlightMission mission;
  mission.origin = {47, 8, 400};
  mission.home_z_m = 0;
  return mission;
}

PreflightFacts GoodFacts() {
  PreflightFacts facts;
  facts.has_camera = true;
  facts.parameters = {
      {"NAV_DLL_ACT", 2}, {"COM_LOW_BAT_ACT", 3}, {"GF_ACTION", 2}, {"RTL_RETURN_ALT", 40}};
  return facts;
}

std::string BlockedBy(const VehicleState& vehicle, const PreflightFacts& facts,
                      const FlightMission& mission, const FlightOptions& options = {}) {
  std::string names;
  for (const auto& item : Blocking(CheckPreflight(vehicle, facts, mission, 20, options), options)) {
    names += item.name + ";";
  }
  return names;
}

TEST(Preflight, AGoodVehicleMayFly) {
  EXPECT_EQ(BlockedBy(GoodVehicle(AutopilotStack::kPx4), GoodFacts(), GoodMission()), "");
}

TEST(Preflight, EachFindingBlocks) {
  VehicleState vehicle = GoodVehicle(AutopilotStack::kPx4);
  vehicle.battery_percent = 30;
  EXPECT_EQ(BlockedBy(vehicle, GoodFacts(), GoodMission()), "battery;");
  vehicle = GoodVehicle(AutopilotStack::kPx4);
  vehicle.sigma_horizontal_m = 9;
  EXPECT_EQ(BlockedBy(vehicle, GoodFacts(), GoodMission()), "position;");
  vehicle = GoodVehicle(AutopilotStack::kPx4);
  vehicle.home->height_m = 402.5;
  EXPECT_EQ(BlockedBy(vehicle, GoodFacts(), GoodMission()), "home;") << "2.5 m off";
  vehicle.home = GeoPosition{48, 8, 400};
  EXPECT_EQ(BlockedBy(vehicle, GoodFacts(), GoodMission()), "home;") << "another site";
  PreflightFacts facts = GoodFacts();
  facts.parameters["RTL_RETURN_ALT"] = 15;
  EXPECT_EQ(BlockedBy(GoodVehicle(AutopilotStack::kPx4), facts, GoodMission()), "return height;");
}

TEST(Preflight, FailsafesThatAreOffBlockUnlessAllowed) {
  PreflightFacts facts = GoodFacts();
  facts.parameters["NAV_DLL_ACT"] = 0;
  facts.parameters.erase("COM_LOW_BAT_ACT");
  const VehicleState vehicle = GoodVehicle(AutopilotStack::kPx4);
  EXPECT_EQ(BlockedBy(vehicle, facts, GoodMission()),
            "failsafe: loss of the data link;failsafe: low battery;");
  FlightOptions options;
  options.allow_disabled_failsafes = true;
  EXPECT_EQ(BlockedBy(vehicle, facts, GoodMission(), options), "");
  EXPECT_NE(BlockedBy(GoodVehicle(AutopilotStack::kArduPilot), GoodFacts(), GoodMission()), "")
      << "PX4's parameters say nothing about ArduPilot";
}

TEST(Telemetry, CapturedImageComesInOurFrames) {
  MavCameraImageCaptured message;
  message.lat = 473769000;
  message.lon = 85417000;
  message.alt = 412500;
  message.image_index = 9;
  message.capture_result = 1;
  message.time_utc = 1'700'000'000'123'456;
  // Looks east, 30 degrees down: q = yaw(90) * pitch(-30), NED from forward-right-down.
  const Eigen::Quaterniond q = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(-M_PI / 6, Eigen::Vector3d::UnitY());
  message.q = {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
               static_cast<float>(q.z())};
  const auto report = ReadCapture(MakeMavFrame(message, {1, 100, 0}), VehicleState());
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->succeeded);
  EXPECT_EQ(report->record.index, 9);
  EXPECT_EQ(report->record.time, "2023-11-14T22:13:20.123456Z");
  EXPECT_NEAR(report->record.position.height_m, 412.5, 1e-9);
  ASSERT_TRUE(report->record.cam_from_enu);
  const ViewDirection seen =
      ViewDirectionOf({*report->record.cam_from_enu, Eigen::Vector3d::Zero()});
  EXPECT_NEAR(seen.yaw_rad, M_PI / 2, 1e-6);
  EXPECT_NEAR(seen.pitch_rad, -M_PI / 6, 1e-6);
}

TEST(Telemetry, VelocityAndHeadingCrossTheBorderToEnu) {
  MavGlobalPositionInt message;
  message.vx = 100;  // north
  message.vy = 200;  // east
  message.vz = 300;  // down
  message.hdg = 27000;
  VehicleState vehicle;
  ASSERT_TRUE(UpdateVehicle(MakeMavFrame(message, {1, 1, 0}), 5, &vehicle));
  EXPECT_TRUE(vehicle.velocity_in_enu.isApprox(Eigen::Vector3d(2, 1, -3)));
  EXPECT_NEAR(vehicle.yaw_rad, -M_PI / 2, 1e-9);
  EXPECT_EQ(vehicle.position_heard_s, 5);
}

TEST(AutopilotDialect, ModesAreTheNotesNumbers) {
  EXPECT_EQ(ModeOf(AutopilotStack::kPx4, 4U << 16U | 3U << 24U), VehicleMode::kGuided);
  EXPECT_EQ(ModeOf(AutopilotStack::kPx4, 4U << 16U | 5U << 24U), VehicleMode::kReturn);
  EXPECT_EQ(ModeOf(AutopilotStack::kPx4, 3U << 16U), VehicleMode::kPilot);
  EXPECT_EQ(ModeOf(AutopilotStack::kPx4, 6U << 16U), VehicleMode::kPilot) << "offboard, not ours";
  EXPECT_EQ(ModeOf(AutopilotStack::kArduPilot, 4), VehicleMode::kGuided);
  EXPECT_EQ(ModeOf(AutopilotStack::kArduPilot, 17), VehicleMode::kBrake);
  EXPECT_EQ(ModeOf(AutopilotStack::kArduPilot, 21), VehicleMode::kReturn);
  EXPECT_EQ(ModeOf(AutopilotStack::kArduPilot, 5), VehicleMode::kPilot);
}

TEST(AutopilotDialect, ATargetNeverTakesTheModeFromAPilot) {
  for (const auto stack : {AutopilotStack::kPx4, AutopilotStack::kArduPilot}) {
    VehicleAddress address;
    address.stack = stack;
    FlightCommand command;
    command.kind = CommandKind::kGoTo;
    command.target = {47, 8, 420};
    command.yaw_rad = -M_PI / 2;
    const auto steps = StepsOf(command, address);
    const auto& go = std::get<MavCommandInt>(steps.at(0).message);
    EXPECT_EQ(go.command, MavCmd::kDoReposition);
    EXPECT_EQ(go.param2, 0) << "the flag that changes the mode";
    EXPECT_EQ(go.frame, MavCoordinateFrame::kGlobal);
    EXPECT_EQ(go.z, 420);
    if (stack == AutopilotStack::kPx4) {
      EXPECT_EQ(steps.size(), 1U);
      EXPECT_NEAR(go.param4, -M_PI / 2, 1e-6) << "radians";
    } else {
      EXPECT_NEAR(std::get<MavCommandLong>(steps.at(1).message).param1, 270, 1e-4) << "degrees";
    }
  }
}

TEST(DryRun, ListsEveryCommand) {
  FlightMission mission = GoodMission();
  mission.stops = {{{10, 0, 12}, {0, 0}, -1, ""}, {{20, 0, 12}, {1, -0.5}, 3, "a.jpg"}};
  const std::string text = DryRunText(mission, AutopilotStack::kPx4, {0, 0, 0}, 5);
  for (const char* word : {"arm", "take-off", "view 3", "view 3 aim", "view 3 photo", "return"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 9) << text;
}

TEST(PlanMission, FenceAndTransitHeightAreAroundEverything) {
  FlightPath path;
  path.waypoints = {{{0, 0, 10}, {}, -1}, {{30, 5, 12}, {}, 4}};
  FlightSite site;
  site.frame = {true, GeoPosition{47, 8, 400}};
  site.home = Eigen::Vector3d(-10, -10, -1);
  site.box = BoundingBox(Eigen::Vector3d(-5, -5, 0), Eigen::Vector3d(5, 5, 20));
  const auto name = [](int id) { return std::to_string(id) + ".jpg"; };
  const FlightMission mission = PlanFlightMission(path, site, name, {});
  EXPECT_EQ(mission.stops.at(1).photo, "4.jpg");
  EXPECT_EQ(mission.transit_z_m, 25);
  EXPECT_EQ(mission.home_z_m, -1);
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(-29, -29), Eigen::Vector2d(49, 24)}) {
    EXPECT_TRUE(IsInsidePolygon(mission.limits.fence, point));
  }
  site.frame.is_metric_enu = false;
  EXPECT_THROW(PlanFlightMission(path, site, name, {}), std::exception);
}

TEST(Checklist, AddsUp) {
  FlightMission mission = GoodMission();
  mission.speed_m_s = 2;
  mission.stops = {{{0, 0, 10}, {}, 1, "a.jpg"}, {{60, 0, 14}, {}, 2, "b.jpg"}};
  const FlightChecklist list = MakeChecklist(mission, 5, 25);
  EXPECT_EQ(list.views, 2);
  EXPECT_NEAR(list.length_m, std::hypot(60, 4), 1e-9);
  EXPECT_EQ(list.lowest_m, 10);
  EXPECT_NEAR(list.minutes, (list.length_m / 2 + 16 + 28) / 60, 1e-9);
  EXPECT_FALSE(list.nearest_m);
  EXPECT_NE(ChecklistText(list, mission).find("views"), std::string::npos);
}

TEST(PictureUrl, ReplacesItsMarks) {
  FetchRequest request;
  request.capture.record.index = 7;
  EXPECT_EQ(PictureUrl(request, "http://c/{resolution}/img_{index5}.jpg?n={index}"),
            "http://c/low/img_00007.jpg?n=7");
  request.capture.file_url = "http://c/x.jpg";
  EXPECT_EQ(PictureUrl(request, ""), "http://c/x.jpg");
}

}  // namespace
}  // namespace colmap_ext
