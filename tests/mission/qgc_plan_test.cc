#include "colmap_ext/mission/qgc_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "colmap_ext/mission/export_formats.h"
#include "colmap_ext/util/error.h"
#include "mission/mission_world.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::json;

// What QGroundControl requires of a plan (its developer guide, "Plan File Format"), checked without
// the code under test.
void ExpectIsPlan(const Json& plan) {
  EXPECT_EQ(plan.at("fileType"), "Plan");
  EXPECT_EQ(plan.at("version"), 1);
  EXPECT_EQ(plan.at("groundStation"), "QGroundControl");
  const Json& mission = plan.at("mission");
  EXPECT_EQ(mission.at("version"), 2);
  EXPECT_TRUE(mission.at("firmwareType") == 12 || mission.at("firmwareType") == 3);
  EXPECT_EQ(mission.at("vehicleType"), 2);
  EXPECT_GT(mission.at("cruiseSpeed").get<double>(), 0);
  EXPECT_GT(mission.at("hoverSpeed").get<double>(), 0);
  EXPECT_EQ(mission.at("globalPlanAltitudeMode"), 1);
  ASSERT_EQ(mission.at("plannedHomePosition").size(), 3u);
  int number = 0;
  for (const Json& item : mission.at("items")) {
    EXPECT_EQ(item.at("type"), "SimpleItem");
    EXPECT_EQ(item.at("doJumpId"), ++number);
    EXPECT_TRUE(item.at("autoContinue").get<bool>());
    ASSERT_EQ(item.at("params").size(), 7u);
    for (const Json& param : item.at("params")) EXPECT_TRUE(param.is_null() || param.is_number());
    const int command = item.at("command");
    const std::set<int> with_place = {16, 22};
    if (with_place.count(command) == 0) {
      EXPECT_EQ(item.at("frame"), 2);
      continue;
    }
    EXPECT_EQ(item.at("frame"), 3);
    EXPECT_EQ(item.at("AltitudeMode"), 1);
    EXPECT_TRUE(item.at("AMSLAltAboveTerrain").is_null());
    EXPECT_EQ(item.at("Altitude"), item.at("params")[6]);
    EXPECT_LE(std::abs(item.at("params")[4].get<double>()), 90);
    EXPECT_LE(std::abs(item.at("params")[5].get<double>()), 180);
  }
  EXPECT_EQ(plan.at("geoFence").at("version"), 2);
  EXPECT_TRUE(plan.at("geoFence").at("circles").is_array());
  EXPECT_TRUE(plan.at("geoFence").at("polygons").is_array());
  EXPECT_EQ(plan.at("rallyPoints").at("version"), 2);
  EXPECT_TRUE(plan.at("rallyPoints").at("points").is_array());
}

std::vector<int> Commands(const Json& plan) {
  std::vector<int> commands;
  for (const Json& item : plan["mission"]["items"]) commands.push_back(item["command"]);
  return commands;
}

TEST(QgcPlan, FliesEachViewWithGimbalHoldCaptureAndDelay) {
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), {}));
  ExpectIsPlan(plan);
  EXPECT_EQ(plan["mission"]["firmwareType"], 12);
  EXPECT_EQ(Commands(plan),
            (std::vector<int>{22, 178, 16, 1000, 16, 2000, 93, 1000, 16, 2000, 93, 20}));
  const Json& items = plan["mission"]["items"];
  EXPECT_NEAR(items[3]["params"][0].get<double>(), -30, 1e-9);  // gimbal pitch
  EXPECT_NEAR(items[4]["params"][0].get<double>(), 2, 1e-9);    // hold
  EXPECT_NEAR(items[4]["params"][3].get<double>(), 270, 1e-9);  // heading west
  EXPECT_EQ(items[5]["params"][2], 1);                          // one photo
  EXPECT_EQ(items[5]["params"][3], 1);                          // first in the sequence
  EXPECT_EQ(items[9]["params"][3], 2);
}

TEST(QgcPlan, PlacesWaypointsOnEarthRelativeToHome) {
  MissionOptions options;
  options.home_below_origin_m = 3;
  options.frame_heights = "ellipsoidal";
  options.geoid_undulation_m = "47";
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), options));
  const Json& home = plan["mission"]["plannedHomePosition"];
  EXPECT_NEAR(home[2].get<double>(), 450 - 3 - 47, 1e-9);
  const Json& item = plan["mission"]["items"][4];
  // 10 m east and 20 m north at 47.4 degrees: by the radii of curvature of WGS84.
  const double a = 6378137.0, e2 = 0.00669437999014, lat = DegToRad(47.4);
  const double w = std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  const double meridian_m = a * (1 - e2) / (w * w * w) + 450;
  const double normal_m = a / w + 450;
  EXPECT_NEAR(item["params"][4].get<double>(), 47.4 + RadToDeg(20 / meridian_m), 1e-8);
  EXPECT_NEAR(item["params"][5].get<double>(), 8.5 + RadToDeg(10 / normal_m / std::cos(lat)), 1e-8);
  EXPECT_NEAR(item["Altitude"].get<double>(), 18, 1e-3);
}

TEST(QgcPlan, TakesHeightsAboveTheSeaWhenAsked) {
  MissionOptions options;
  options.frame_heights = "amsl";
  options.height_reference = "amsl";
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), options));
  EXPECT_EQ(plan["mission"]["globalPlanAltitudeMode"], 2);
  const Json& item = plan["mission"]["items"][4];
  EXPECT_EQ(item["AltitudeMode"], 2);
  EXPECT_EQ(item["frame"], 0);
  EXPECT_NEAR(item["Altitude"].get<double>(), 465, 1e-3);
}

TEST(QgcPlan, TurnsArduPilotByItsOwnCommand) {
  MissionOptions options;
  options.autopilot = "ardupilot";
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), options));
  ExpectIsPlan(plan);
  EXPECT_EQ(plan["mission"]["firmwareType"], 3);
  EXPECT_EQ(Commands(plan), (std::vector<int>{22, 178, 16, 1000, 16, 115, 93, 2000, 93, 1000, 16,
                                              115, 93, 2000, 93, 20}));
}

TEST(QgcPlan, TakesOffAtLeastToTheFirstWaypoint) {
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), {}));
  EXPECT_NEAR(plan["mission"]["items"][0]["Altitude"].get<double>(), 12, 1e-6);
  MissionOptions options;
  options.takeoff_height_m = 30;
  const Json higher = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), options));
  EXPECT_NEAR(higher["mission"]["items"][0]["Altitude"].get<double>(), 30, 1e-6);
}

TEST(QgcPlan, WritesTheFence) {
  MissionOptions options;
  options.fence = {{{47, 8, 0}, {48, 8, 0}, {48, 9, 0}}};
  options.no_fly = {{{47.1, 8.1, 0}, {47.2, 8.1, 0}, {47.2, 8.2, 0}}};
  const Json plan = Json::parse(QgcPlan(TwoViewsAndATurn(), FrameOnEarth(), options));
  const Json& polygon = plan["geoFence"]["polygons"].at(0);
  EXPECT_EQ(polygon.at("version"), 1);
  EXPECT_TRUE(polygon.at("inclusion").get<bool>());
  EXPECT_EQ(polygon.at("polygon"), Json::parse("[[47.0,8.0],[48.0,8.0],[48.0,9.0]]"));
  EXPECT_FALSE(plan["geoFence"]["polygons"].at(1).at("inclusion").get<bool>());
}

TEST(QgcPlan, RefusesWhatCannotBeFlown) {
  const FlightPath path = TwoViewsAndATurn();
  EXPECT_THROW(QgcPlan(path, WorldFrame{true, std::nullopt}, {}), Error);
  EXPECT_THROW(QgcPlan(path, WorldFrame{false, GeoPosition{1, 1, 1}}, {}), Error);
  EXPECT_THROW(QgcPlan(FlightPath{}, FrameOnEarth(), {}), Error);
  MissionOptions options;
  options.home_below_origin_m = -14;  // home above the second waypoint: too low to fly
  EXPECT_THROW(QgcPlan(path, FrameOnEarth(), options), Error);
  options = {};
  options.autopilot = "toaster";
  EXPECT_THROW(QgcPlan(path, FrameOnEarth(), options), UsageError);
  options = {};
  options.fence = {{{47, 8, 0}, {48, 8, 0}}};
  EXPECT_THROW(QgcPlan(path, FrameOnEarth(), options), UsageError);
}

TEST(GeoJson, HasThePathAndItsViewsLongitudeFirst) {
  const Json json = Json::parse(GeoJson(MissionOf({})));
  EXPECT_EQ(json.at("type"), "FeatureCollection");
  ASSERT_EQ(json.at("features").size(), 3u);
  const Json& line = json["features"][0];
  EXPECT_EQ(line["geometry"]["type"], "LineString");
  ASSERT_EQ(line["geometry"]["coordinates"].size(), 3u);
  EXPECT_NEAR(line["geometry"]["coordinates"][0][0].get<double>(), 8.5, 1e-9);
  EXPECT_NEAR(line["geometry"]["coordinates"][0][1].get<double>(), 47.4, 1e-9);
  EXPECT_NEAR(line["geometry"]["coordinates"][0][2].get<double>(), 462, 1e-6);
  EXPECT_EQ(json["features"][1]["properties"]["view_id"], 7);
  EXPECT_NEAR(json["features"][2]["properties"]["yaw_deg"].get<double>(), 45, 1e-9);
}

}  // namespace
}  // namespace colmap_ext
