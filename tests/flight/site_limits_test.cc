// Geofence, no-fly zones and altitudes of a site: what the planner's limits mean to the daemon.
#include <gtest/gtest.h>

#include "colmap_ext/flight/plan_mission.h"
#include "colmap_ext/flight/segment_checks.h"
#include "colmap_ext/util/error.h"
#include "flight/api_call.h"
#include "flight/flight_harness.h"

namespace colmap_ext {
namespace {

using test::FlightHarness;
using test::MissionAround;

FlightZone Square(const std::string& name, double x, double y, double half_m) {
  FlightZone zone;
  zone.kind = FlightZone::Kind::kExclusion;
  zone.name = name;
  zone.rings = {{{x - half_m, y - half_m},
                 {x + half_m, y - half_m},
                 {x + half_m, y + half_m},
                 {x - half_m, y + half_m}}};
  return zone;
}

// The harness flies a circle of 12 m around the origin.
FlightMission WithZone(const FlightZone& zone) {
  FlightMission mission = MissionAround(6);
  mission.limits.site.zones.push_back(zone);
  return mission;
}

int StatusOf(const FlightMission& mission, std::string* reason) {
  ApiRequest request{"POST", "/v1/mission", "127.0.0.1",
                     "",     "Bearer t",    MissionToJson(mission).dump()};
  try {
    ParseApiCall(request, "t", {});
    return 200;
  } catch (const ApiError& error) {
    *reason = error.what();
    return error.status();
  }
}

TEST(SiteLimits, ComeBackFromJson) {
  FlightMission mission = WithZone(Square("school", 30, 0, 2));
  FlightZone fence = Square("", 0, 0, 35);
  fence.kind = FlightZone::Kind::kInclusion;
  fence.rings.push_back({{20, 20}, {21, 20}, {20, 21}});
  fence.max_z_m = 60;
  mission.limits.site.zones.push_back(fence);
  mission.limits.site.min_z_m = -2;
  const FlightMission read = MissionFromJson(MissionToJson(mission), "mission");
  const FlightLimits& site = read.limits.site;
  ASSERT_EQ(site.zones.size(), 2U);
  EXPECT_EQ(site.zones[0].kind, FlightZone::Kind::kExclusion);
  EXPECT_EQ(site.zones[0].name, "school");
  EXPECT_EQ(site.zones[0].rings, mission.limits.site.zones[0].rings);
  EXPECT_TRUE(std::isinf(site.zones[0].max_z_m));
  EXPECT_EQ(site.zones[1].kind, FlightZone::Kind::kInclusion);
  EXPECT_EQ(site.zones[1].rings, fence.rings);
  EXPECT_EQ(site.zones[1].max_z_m, 60);
  EXPECT_EQ(site.min_z_m, -2);
  EXPECT_TRUE(std::isinf(site.max_z_m));
  EXPECT_EQ(MissionToJson(read), MissionToJson(mission));
}

TEST(SiteLimits, AMissionThatLeavesThemIsRefusedWithTheReason) {
  std::string reason;
  EXPECT_EQ(StatusOf(WithZone(Square("school", 30, 0, 2)), &reason), 200) << reason;
  EXPECT_EQ(StatusOf(WithZone(Square("school", 0, -12, 1)), &reason), 400);
  EXPECT_NE(reason.find("stop 0"), std::string::npos) << reason;
  EXPECT_NE(reason.find("school"), std::string::npos) << reason;
  // Between the first two stops, and nowhere else.
  EXPECT_EQ(StatusOf(WithZone(Square("", 5.2, -9, 0.5)), &reason), 400);
  EXPECT_NE(reason.find("way from stop 0 to stop 1"), std::string::npos) << reason;
  FlightMission high = MissionAround(6);
  high.limits.site.max_z_m = 9.2;
  EXPECT_EQ(StatusOf(high, &reason), 400);
  EXPECT_NE(reason.find("highest altitude"), std::string::npos) << reason;
  FlightZone fence = Square("", 0, 0, 10);
  fence.kind = FlightZone::Kind::kInclusion;
  EXPECT_EQ(StatusOf(WithZone(fence), &reason), 400);
  EXPECT_NE(reason.find("outside the geofence"), std::string::npos) << reason;
}

TEST(SiteLimits, ZonesThatAreNoneAreRefused) {
  std::string reason;
  FlightZone line = Square("", 30, 0, 2);
  line.rings[0].resize(2);
  EXPECT_EQ(StatusOf(WithZone(line), &reason), 400);
  EXPECT_NE(reason.find("3 corners"), std::string::npos) << reason;
  FlightZone empty = Square("", 30, 0, 2);
  empty.rings.clear();
  EXPECT_EQ(StatusOf(WithZone(empty), &reason), 400);
  FlightZone upside_down = Square("", 30, 0, 2);
  upside_down.min_z_m = 5;
  upside_down.max_z_m = 4;
  EXPECT_EQ(StatusOf(WithZone(upside_down), &reason), 400);
  Json json = MissionToJson(WithZone(Square("", 30, 0, 2)));
  json["limits"]["zones"][0]["fence"] = "perhaps";
  EXPECT_THROW(MissionFromJson(json, "mission"), Error);
}

TEST(SiteLimits, AppendedStopsAreCheckedToo) {
  FlightHarness flight({});
  const FlightMission mission = WithZone(Square("pond", 0, 30, 2));
  flight.Accept(test::LoadRequest(mission));
  FlightRequest append = test::LoadRequest(mission);
  append.kind = FlightRequest::Kind::kAppend;
  append.mission.revision = 2;
  append.stops = test::StopsAround(1, 50);
  append.stops[0].position = {0, 30, 9};
  const FlightReply reply = flight.Request(append);
  EXPECT_FALSE(reply.is_accepted);
  EXPECT_NE(reply.reason.find("pond"), std::string::npos) << reply.reason;
}

TEST(SiteLimits, TheWayToAStopKeepsOutToo) {
  FlightSpace space;
  space.limits.min_relative_height_m = 0;
  space.limits.site.zones.push_back(Square("pond", 0, 0, 2));
  EXPECT_EQ(CheckSegment(space, {-10, 5, 5}, {10, 5, 5}), "");
  EXPECT_NE(CheckSegment(space, {-10, 0, 5}, {10, 0, 5}), "");
  EXPECT_NE(CheckSegment(space, {-10, 0, 5}, {0, 0, 5}).find("pond"), std::string::npos);
  // Where it is, it is: it may come out, but not through.
  EXPECT_EQ(CheckSegment(space, {1, 0, 5}, {10, 0, 5}), "");
  EXPECT_NE(CheckSegment(space, {1, 0, 5}, {1.5, 0, 5}), "");
}

TEST(SiteLimits, PlannedMissionsCarryThem) {
  FlightPath path;
  path.waypoints.resize(2);
  path.waypoints[1].position = {0, 10, 10};
  FlightSite site;
  site.frame.is_metric_enu = true;
  site.frame.origin = test::kSite;
  site.limits.zones.push_back(Square("school", 30, 0, 2));
  site.limits.max_z_m = 50;
  const FlightMission mission =
      PlanFlightMission(path, site, [](int) { return std::string("x.jpg"); }, {});
  ASSERT_EQ(mission.limits.site.zones.size(), 1U);
  EXPECT_EQ(mission.limits.site.max_z_m, 50);
}

class SiteLimitsInFlight : public ::testing::TestWithParam<AutopilotPersonality> {};

// The zone is in the vehicle's own fence as well, and the flight keeps away from it.
TEST_P(SiteLimitsInFlight, AFlightBesideANoFlyZone) {
  FlightHarness::Options options;
  options.personality = GetParam();
  FlightHarness flight(options);
  ASSERT_NO_FATAL_FAILURE(flight.Begin(WithZone(Square("school", 30, 0, 6))));
  ASSERT_TRUE(flight.RunUntilState(600, FlightState::kDisarmed)) << flight.Describe();
  EXPECT_EQ(flight.CountViews(ViewStatus::kStored), 6) << flight.journal();
  bool has_fence = false;
  for (const PreflightItem& item : flight.controller().machine().preflight()) {
    if (item.name != "fence in the vehicle") continue;
    has_fence = true;
    EXPECT_TRUE(item.is_good) << item.text;
  }
  EXPECT_TRUE(has_fence);
}

INSTANTIATE_TEST_SUITE_P(Stacks, SiteLimitsInFlight, test::BothStacks(), test::NameOfStack);

}  // namespace
}  // namespace colmap_ext
