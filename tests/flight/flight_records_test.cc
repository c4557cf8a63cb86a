// Missions as JSON, journal, ledger.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <random>

#include "colmap_ext/flight/flight_journal.h"
#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

FlightMission SomeMission() {
  FlightMission mission;
  mission.origin = {47.3769, 8.5417, 455.25};
  mission.undulation_m = 47.1;
  mission.home_z_m = -1.5;
  mission.transit_z_m = 30;
  mission.surface_path = "/w/surface.ply";
  mission.at_end = AtEnd::kHold;
  mission.limits.fence = {{0, 0}, {10, 0}, {10, 10}};
  mission.stops = {{{1, 2, 3}, {0.5, -0.25}, -1, ""}, {{4, 5, 6}, {-3, 0.1}, 7, "view_7.jpg"}};
  return mission;
}

TEST(FlightMission, ComesBackFromJson) {
  const FlightMission mission = SomeMission();
  const FlightMission back = MissionFromJson(Json::parse(MissionToJson(mission).dump()), "test");
  ASSERT_EQ(back.stops.size(), 2U);
  EXPECT_EQ(back.stops[1].position, mission.stops[1].position);
  EXPECT_NEAR(back.stops[1].direction.yaw_rad, -3, 1e-12);
  EXPECT_EQ(back.stops[0].view_id, -1);
  EXPECT_EQ(back.stops[1].photo, "view_7.jpg");
  EXPECT_EQ(back.home_z_m, mission.home_z_m);
  EXPECT_EQ(back.transit_z_m, mission.transit_z_m);
  EXPECT_EQ(back.at_end, AtEnd::kHold);
  EXPECT_EQ(back.limits.fence, mission.limits.fence);
  EXPECT_EQ(back.surface_path, mission.surface_path);
  EXPECT_EQ(back.undulation_m, mission.undulation_m);
}

TEST(FlightMission, BadOnesAreNamed) {
  const auto expect = [](const std::function<void(Json*)>& spoil,
                         std::initializer_list<std::string> words) {
    Json json = MissionToJson(SomeMission());
    spoil(&json);
    ExpectError([&] { MissionFromJson(json, "body"); }, words);
  };
  expect([](Json* j) { (*j)["stops"][1]["photo"] = "../x.jpg"; }, {"file name"});
  expect([](Json* j) { (*j)["stops"][0]["position_enu_m"] = {1, 2}; }, {"/stops/0"});
  expect(
      [](Json* j) {
        (*j)["stops"][0]["view_id"] = 7;
        (*j)["stops"][0]["photo"] = "b.jpg";
      },
      {"occurs twice"});
  expect([](Json* j) { j->erase("origin"); }, {"origin"});
  expect([](Json* j) { (*j)["speed_m_s"] = 0; }, {"speed_m_s"});
  expect([](Json* j) { (*j)["at_end"] = "explode"; }, {"/at_end", "hold"});
  expect([](Json* j) { (*j)["surface_path"] = ""; }, {"vouched"});
  expect([](Json* j) { (*j)["limits"]["fence_enu_m"] = {{1, 2}, {3, 4}}; }, {"fence_enu_m"});
}

TEST(FlightMission, WorldAndSeaLevelAreEachOthersInverse) {
  const FlightMission mission = SomeMission();
  const Eigen::Vector3d point(30, -20, 12);
  const GeoPosition amsl = mission.AmslFromWorld(point);
  EXPECT_LT((mission.WorldFromAmsl(amsl) - point).norm(), 1e-6);
  EXPECT_NEAR(amsl.height_m, 455.25 + 12 - 47.1, 0.01);
}

CaptureReport Picture(int index) {
  CaptureReport report;
  report.record.index = index;
  report.record.time = "2026-01-01T00:00:0" + std::to_string(index % 10) + "Z";
  report.record.position = {47, 8, 400};
  report.record.cam_from_enu = Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);
  report.relative_height_m = 12;
  return report;
}

std::vector<Json> SomeRecords() {
  return {
      {{"type", "start"}},
      {{"type", "ask"}, {"view", 7}, {"photo", "a.jpg"}, {"sequence", 1}, {"after_index", 4}},
      CaptureToJson(7, Picture(5)),
      {{"type", "stored"}, {"view", 7}, {"resolution", "low"}, {"file", "a.jpg"}, {"sha256", "x"}},
      {{"type", "ask"}, {"view", 8}, {"photo", "b.jpg"}, {"sequence", 2}, {"after_index", 5}},
      {{"type", "failed"}, {"view", 9}, {"reason", "gimbal"}},
      CaptureToJson(-1, Picture(6)),
      {{"type", "something new"}, {"x", 1}},
  };
}

void ExpectSomeLedger(const FlightLedger& ledger) {
  EXPECT_EQ(ledger.flights, 1);
  EXPECT_TRUE(ledger.was_flying);
  EXPECT_EQ(ledger.next_sequence, 3);
  EXPECT_EQ(ledger.last_index, 6);
  EXPECT_EQ(ledger.views.at(7).status, ViewStatus::kStored);
  EXPECT_EQ(ledger.views.at(7).capture.record.index, 5);
  EXPECT_EQ(ledger.views.at(7).capture.relative_height_m, 12);
  ASSERT_TRUE(ledger.views.at(7).capture.record.cam_from_enu);
  EXPECT_EQ(ledger.views.at(8).status, ViewStatus::kAsked);
  EXPECT_EQ(ledger.views.at(9).status, ViewStatus::kFailed);
  EXPECT_EQ(ledger.others.count(6), 1U);
}

TEST(FlightJournal, ReplaysWhatWasWritten) {
  const TestFolder folder;
  const auto path = folder / "flight/journal.jsonl";
  FlightJournal(path).Append(SomeRecords());
  ExpectSomeLedger(FlightJournal(path).ledger());
}

TEST(FlightJournal, ACaptureTwiceIsOnePicture) {
  std::string text;
  for (const Json& record : SomeRecords()) text += record.dump() + "\n" + record.dump() + "\n";
  const FlightLedger ledger = ReplayJournal(text, "twice");
  EXPECT_EQ(ledger.views.at(7).status, ViewStatus::kStored);
  EXPECT_EQ(ledger.others.size(), 1U);
}

// Cut anywhere, it replays the whole lines and goes on behind them.
TEST(FlightJournal, GoesOnBehindWhatACrashLeft) {
  std::string text;
  for (const Json& record : SomeRecords()) text += record.dump() + "\n";
  const TestFolder folder;
  const auto path = folder / "journal.jsonl";
  for (std::size_t length = 0; length <= text.size(); length += 7) {
    std::ofstream(path, std::ios::binary) << text.substr(0, length);
    { FlightJournal(path).Append({{{"type", "end"}}}); }
    const std::string after = ReadFile(path);
    const std::size_t whole = length == 0 ? 0 : text.rfind('\n', length - 1) + 1;
    ASSERT_EQ(after, text.substr(0, whole) + "{\"type\":\"end\"}\n") << length;
    EXPECT_FALSE(FlightJournal(path).ledger().was_flying);
  }
}

TEST(FlightJournal, DamageInTheMiddleIsNamed) {
  const TestFolder folder;
  const auto path = folder / "journal.jsonl";
  std::ofstream(path) << "{\"type\":\"start\"}\nrubbish\n{\"type\":\"end\"}\n";
  ExpectError([&] { FlightJournal journal(path); }, {"journal.jsonl", "line 2"});
  std::ofstream(path) << "{\"type\":\"ask\",\"view\":1}\n";
  ExpectError([&] { FlightJournal journal(path); }, {"line 1", "photo"});
}

}  // namespace
}  // namespace colmap_ext
