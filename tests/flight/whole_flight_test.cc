// Whole flights against the simulated autopilot, both personalities, with a good and a bad link.
#include <gtest/gtest.h>

#include "flight/flight_harness.h"

namespace colmap_ext {
namespace {

using test::FlightHarness;
using test::LoadRequest;
using test::MissionAround;
using test::Plain;
using test::StopsAround;

class WholeFlight : public ::testing::TestWithParam<AutopilotPersonality> {
 protected:
  FlightHarness::Options Options() const {
    FlightHarness::Options options;
    options.personality = GetParam();
    return options;
  }
};

TEST_P(WholeFlight, TakesEveryPictureOnceAndLandsAtHome) {
  FlightHarness flight(Options());
  ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(6)));
  ASSERT_TRUE(flight.RunUntilState(600, FlightState::kDisarmed)) << flight.Describe();
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 6) << flight.journal();
  EXPECT_EQ(flight.truth().captures, 6);
  flight.ExpectPicturesAccounted();
  EXPECT_FALSE(flight.truth().has_crashed);
  EXPECT_LT((flight.truth().motion.position - Eigen::Vector3d(0, -20, 0)).norm(), 2);
}

TEST_P(WholeFlight, PicturesAreTakenAtTheirViews) {
  FlightHarness flight(Options());
  const FlightMission mission = MissionAround(5);
  ASSERT_NO_FATAL_FAILURE(flight.Begin(mission));
  ASSERT_TRUE(flight.RunUntilState(600, FlightState::kDisarmed)) << flight.Describe();
  const std::vector<ShutterEvent> events = flight.drone().TakeShutterEvents();
  ASSERT_EQ(events.size(), 5U);
  for (const ShutterEvent& event : events) {
    const FlightStop& stop = mission.stops[static_cast<std::size_t>(event.index)];
    // Tolerance of the hover, and GPS that wanders by 0.3 m.
    EXPECT_LT((event.position - stop.position).norm(), 2) << event.index;
    EXPECT_LT(std::abs(NormalizeAngle(event.direction.yaw_rad - stop.direction.yaw_rad)),
              DegToRad(5));
    EXPECT_NEAR(event.direction.pitch_rad, stop.direction.pitch_rad, DegToRad(2));
    const CaptureReport& report = flight.ledger().views.at(stop.view_id).capture;
    EXPECT_LT((mission.WorldFromAmsl(report.record.position) - stop.position).norm(), 2);
    ASSERT_TRUE(report.record.cam_from_enu);
    const ViewDirection told =
        ViewDirectionOf({*report.record.cam_from_enu, Eigen::Vector3d::Zero()});
    EXPECT_LT(std::abs(NormalizeAngle(told.yaw_rad - stop.direction.yaw_rad)), DegToRad(5));
    EXPECT_NEAR(told.pitch_rad, stop.direction.pitch_rad, DegToRad(2));
  }
}

TEST_P(WholeFlight, AFifthOfAllPacketsMayBeLost) {
  FlightHarness::Options options = Options();
  options.loss = 0.2;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    FlightHarness flight(options);
    ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(8)));
    ASSERT_TRUE(flight.RunUntilState(1500, FlightState::kDisarmed)) << flight.Describe();
    EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 8) << flight.journal();
    flight.ExpectPicturesAccounted();
  }
}

TEST_P(WholeFlight, OlderGimbalAndCameraDoToo) {
  FlightHarness::Options options = Options();
  options.gimbal_protocol = "mount";
  options.camera_protocol = "trigger";
  FlightHarness flight(options);
  ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(4)));
  ASSERT_TRUE(flight.RunUntilState(600, FlightState::kDisarmed)) << flight.Describe();
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 4) << flight.journal();
  EXPECT_EQ(flight.truth().captures, 4);
}

TEST_P(WholeFlight, MoreViewsCanBeAppendedInTheAir) {
  FlightHarness flight(Options());
  FlightMission mission = MissionAround(3);
  mission.at_end = AtEnd::kHold;
  ASSERT_NO_FATAL_FAILURE(flight.Begin(mission));
  ASSERT_TRUE(flight.RunUntilState(400, FlightState::kHold)) << flight.Describe();
  FlightRequest append = LoadRequest(mission);
  append.kind = FlightRequest::Kind::kAppend;
  append.mission.revision = 2;
  append.mission.at_end = AtEnd::kReturn;
  append.stops = StopsAround(4, 100);
  flight.Accept(append);
  EXPECT_FALSE(flight.Request(append).is_accepted) << "the same revision twice";
  ASSERT_TRUE(flight.RunUntilState(600, FlightState::kDisarmed)) << flight.Describe();
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 7);
  EXPECT_EQ(flight.truth().arm_commands, 1) << "one flight";
}

TEST_P(WholeFlight, DisabledFailsafesForbidToArmUnlessAllowed) {
  FlightHarness::Options options = Options();
  options.failsafes = "stock";
  {
    FlightHarness flight(options);
    ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(2)));
    flight.Run(60);
    EXPECT_EQ(flight.state(), FlightState::kIdentified);
    EXPECT_FALSE(flight.truth().is_armed);
    EXPECT_EQ(flight.truth().arm_commands, 0);
    EXPECT_NE(flight.controller().machine().reason().find("failsafe"), std::string::npos);
  }
  options.flight.allow_disabled_failsafes = true;
  FlightHarness flight(options);
  ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(2)));
  EXPECT_TRUE(flight.RunUntilState(300, FlightState::kDisarmed)) << flight.Describe();
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 2);
}

TEST_P(WholeFlight, AViewInsideTheBuildingIsNotFlownTo) {
  FlightHarness flight(Options());
  FlightMission mission = MissionAround(4);
  mission.stops[2].position = {0, 0, 4};
  ASSERT_NO_FATAL_FAILURE(flight.Begin(mission));
  double nearest = 1e9;
  flight.RunUntil(600, [&] {
    nearest = std::min(nearest, test::kBuilding.exteriorDistance(flight.truth().motion.position));
    return flight.state() == FlightState::kDisarmed;
  });
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 3);
  EXPECT_EQ(flight.ledger().views.at(2).status, ViewStatus::kFailed);
  EXPECT_GT(nearest, 3) << "4 m are wanted, less what GPS and hover are off";
}

INSTANTIATE_TEST_SUITE_P(Stacks, WholeFlight, test::BothStacks(), test::NameOfStack);

}  // namespace
}  // namespace colmap_ext
