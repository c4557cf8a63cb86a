// Every fault of the simulated drone at every state of the machine: what the daemon does, that it
// moves nothing after a pilot or a restart, that every picture is accounted for once, and that the
// vehicle ends in hover, return or land.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "flight/flight_harness.h"

namespace colmap_ext {
namespace {

using test::FlightHarness;
using test::MissionAround;
using test::Plain;

enum class Fault {
  kLoss,
  kLinkCut,
  kLinkGone,
  kGpsGlitch,
  kGpsLost,
  kCameraRefuses,
  kCameraFails,
  kCameraSilent,
  kGimbalStuck,
  kPilot,
  kLowBattery,
  kDaemonKilled,
};

constexpr std::array kFaults = {Fault::kLoss,        Fault::kLinkCut,      Fault::kLinkGone,
                                Fault::kGpsGlitch,   Fault::kGpsLost,      Fault::kCameraRefuses,
                                Fault::kCameraFails, Fault::kCameraSilent, Fault::kGimbalStuck,
                                Fault::kPilot,       Fault::kLowBattery,   Fault::kDaemonKilled};
constexpr std::array kFaultNames = {"Loss",        "LinkCut",       "LinkGone",    "GpsGlitch",
                                    "GpsLost",     "CameraRefuses", "CameraFails", "CameraSilent",
                                    "GimbalStuck", "Pilot",         "LowBattery",  "DaemonKilled"};
constexpr std::array kStates = {FlightState::kArmed,  FlightState::kTakeoff, FlightState::kGoto,
                                FlightState::kSettle, FlightState::kAim,     FlightState::kCapture,
                                FlightState::kFetch,  FlightState::kReturn};

struct Case {
  AutopilotPersonality personality;
  Fault fault;
};

class FaultTable : public ::testing::TestWithParam<Case> {
 protected:
  // A flight that has just come to `state`; nothing when it never does.
  std::unique_ptr<FlightHarness> FlightAt(FlightState state) const {
    FlightHarness::Options options;
    options.personality = GetParam().personality;
    options.fetch_s = 3;
    auto flight = std::make_unique<FlightHarness>(options);
    flight->Begin(MissionAround(3));
    if (!flight->RunUntilState(300, state)) return nullptr;
    return flight;
  }

  static std::string PilotMode(AutopilotPersonality personality) {
    return personality == AutopilotPersonality::kPx4 ? "POSCTL" : "LOITER";
  }

  void Inject(FlightHarness* flight) const {
    SimulatedAutopilot& drone = flight->drone();
    switch (GetParam().fault) {
      case Fault::kLoss:
        return flight->SetLoss(0.2);
      case Fault::kLinkCut:
      case Fault::kLinkGone:
        return flight->CutLink(true);
      case Fault::kGpsGlitch:
        return drone.SetGpsGlitch(20);
      case Fault::kGpsLost:
        return drone.SetGpsLost(true);
      case Fault::kCameraRefuses:
        return drone.SetCameraFault(CameraFault::kRefuses);
      case Fault::kCameraFails:
        return drone.SetCameraFault(CameraFault::kReports);
      case Fault::kCameraSilent:
        return drone.SetCameraFault(CameraFault::kSilent);
      case Fault::kGimbalStuck:
        return drone.SetGimbalStuck(true);
      case Fault::kPilot:
        return drone.PilotSwitch(PilotMode(GetParam().personality));
      case Fault::kLowBattery:
        return drone.SetBatteryPercent(26);
      case Fault::kDaemonKilled:
        flight->KillDaemon(1, true);
        return flight->StartDaemon();
    }
  }

  // What takes its time: the fault, what follows from it, and its end where it has one.
  void LiveWith(FlightHarness* flight) const {
    flight->Run(20);
    if (GetParam().fault == Fault::kLinkCut) flight->CutLink(false);
    if (GetParam().fault == Fault::kGpsGlitch) flight->drone().SetGpsGlitch(0);
    if (GetParam().fault == Fault::kGpsLost) flight->drone().SetGpsLost(false);
    flight->RunUntil(400, [&] { return flight->state() == FlightState::kDisarmed; });
    flight->CutLink(false);  // so that the camera can say what it took
    flight->Run(20);
  }

  static void ExpectGoodEnd(const FlightHarness& flight) {
    const DroneTruth truth = flight.truth();
    EXPECT_FALSE(truth.has_crashed) << flight.Describe();
    const bool hovers = truth.motion.velocity.norm() < 1.5;
    const bool goes_home = truth.mode == "RTL" || truth.mode == "LAND";
    EXPECT_TRUE(!truth.is_armed || hovers || goes_home) << flight.Describe();
  }
};

TEST_P(FaultTable, EveryStateEndsWell) {
  for (const FlightState state : kStates) {
    SCOPED_TRACE(Name(state));
    const auto flight = FlightAt(state);
    ASSERT_TRUE(flight);
    const bool obeys_nobody =
        GetParam().fault == Fault::kPilot || GetParam().fault == Fault::kDaemonKilled;
    Inject(flight.get());
    // A report that was on its way before the switch may release one command.
    flight->Run(0.1);
    const int commands = flight->truth().motion_commands;
    LiveWith(flight.get());
    ExpectGoodEnd(*flight);
    flight->ExpectPicturesAccounted();
    if (obeys_nobody) {
      EXPECT_EQ(flight->truth().motion_commands, commands)
          << "nothing may move it before somebody says resume: " << flight->Describe();
    }
    if (GetParam().fault == Fault::kPilot && flight->truth().is_armed) {
      EXPECT_EQ(flight->state(), FlightState::kPilotOverride) << flight->Describe();
      EXPECT_FALSE(flight->Request(Plain(FlightRequest::Kind::kAbort)).is_accepted);
    }
    if (GetParam().fault == Fault::kLoss) {
      EXPECT_EQ(flight->CountViews(ViewStatus::kStored), 3) << flight->Describe();
    }
    if (GetParam().fault == Fault::kGimbalStuck || GetParam().fault == Fault::kCameraRefuses) {
      EXPECT_EQ(flight->state(), FlightState::kDisarmed) << "it went home: " << flight->Describe();
    }
  }
}

class PilotTakesOver : public ::testing::TestWithParam<AutopilotPersonality> {};

// At every state, and at many moments of it: from the switch on, no command that moves anything.
TEST_P(PilotTakesOver, NothingIsCommandedFromThatMomentOn) {
  for (const FlightState state : kStates) {
    for (int delay = 1; delay <= 60; delay += 7) {
      SCOPED_TRACE(std::string(Name(state)) + " + " + std::to_string(0.02 * delay) + " s");
      FlightHarness::Options options;
      options.personality = GetParam();
      FlightHarness flight(options);
      flight.Begin(MissionAround(2));
      ASSERT_TRUE(flight.RunUntilState(300, state));
      flight.Run(0.02 * delay);
      const int commands = flight.truth().motion_commands;
      flight.drone().PilotSwitch(GetParam() == AutopilotPersonality::kPx4 ? "POSCTL" : "LOITER");
      flight.Run(12);
      ASSERT_EQ(flight.truth().motion_commands, commands) << flight.Describe();
      if (flight.truth().is_armed) {
        EXPECT_EQ(flight.state(), FlightState::kPilotOverride) << flight.Describe();
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Stacks, PilotTakesOver, test::BothStacks(), test::NameOfStack);

std::vector<Case> AllCases() {
  std::vector<Case> cases;
  for (const auto personality : {AutopilotPersonality::kPx4, AutopilotPersonality::kArduPilot}) {
    for (const Fault fault : kFaults) cases.push_back({personality, fault});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Faults, FaultTable, ::testing::ValuesIn(AllCases()), [](const auto& info) {
  const bool is_px4 = info.param.personality == AutopilotPersonality::kPx4;
  return std::string(is_px4 ? "Px4" : "ArduPilot") +
         kFaultNames[static_cast<std::size_t>(info.param.fault)];
});

class Restart : public ::testing::TestWithParam<AutopilotPersonality> {};

// kill -9 at 50 random moments; the records on their way to the disk are cut anywhere.
TEST_P(Restart, NothingIsFlownTwiceAndNothingIsLost) {
  std::mt19937 random(5);
  const auto uniform = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  int kills = 0;
  for (std::uint32_t seed = 1; kills < 50; ++seed) {
    FlightHarness::Options options;
    options.personality = GetParam();
    options.seed = seed;
    FlightHarness flight(options);
    ASSERT_NO_FATAL_FAILURE(flight.Begin(MissionAround(5)));
    for (int kill = 0; kill < 5; ++kill) {
      flight.Run(1 + 14 * uniform());
      if (flight.state() == FlightState::kDisarmed) break;
      const int captured = flight.truth().captures;
      flight.KillDaemon(uniform() < 0.5 ? 1.0 : uniform(), uniform() < 0.5);
      ++kills;
      flight.Run(3 * uniform());
      const int commands = flight.truth().motion_commands;
      flight.StartDaemon();
      flight.Run(12);
      ASSERT_EQ(flight.truth().motion_commands, commands) << flight.Describe();
      EXPECT_LE(flight.truth().captures, captured + 1);
      const FlightReply reply = flight.Request(Plain(FlightRequest::Kind::kResume));
      if (!reply.is_accepted && flight.truth().is_landed) {
        flight.Accept(Plain(FlightRequest::Kind::kStart));
      }
    }
    // From wherever it is, the flight can be finished.
    for (int i = 0; i < 4 && flight.CountViews(ViewStatus::kStored) < 5; ++i) {
      flight.RunUntil(300, [&] { return flight.state() == FlightState::kDisarmed; });
      if (flight.state() == FlightState::kDisarmed || flight.state() == FlightState::kIdentified) {
        flight.Request(Plain(FlightRequest::Kind::kStart));
      } else {
        flight.Request(Plain(FlightRequest::Kind::kResume));
      }
    }
    flight.RunUntilState(300, FlightState::kDisarmed);
    EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 5) << flight.Describe();
    flight.ExpectPicturesAccounted();
    EXPECT_LE(flight.truth().captures, 5 + 5) << "at most the one that a kill left open";
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Stacks, Restart, test::BothStacks(), test::NameOfStack);

}  // namespace
}  // namespace colmap_ext
