#include "colmap_ext/scene/view_plan_io.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

constexpr GeoPosition kOrigin{.lat_deg = 33.627, .lon_deg = -116.405, .height_m = 912.34};

std::vector<PlannedView> RandomViews(int count) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<PlannedView> views;
  for (int i = 0; i < count; ++i) {
    PlannedView view;
    view.id = 10 + i;
    view.position = 100 * Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    view.direction = {.yaw_rad = 3.14 * uniform(random), .pitch_rad = 1.57 * uniform(random)};
    view.score = 1e6 * uniform(random);
    views.push_back(view);
  }
  return views;
}

FlightPath RandomPath() {
  FlightPath flight_path;
  for (const PlannedView& view : RandomViews(7)) {
    flight_path.waypoints.push_back(
        {.position = view.position, .direction = view.direction, .view_id = view.id % 3 - 1});
  }
  flight_path.length_m = 123.45678901234567;
  flight_path.duration_s = 0.1;
  flight_path.min_clearance_m = 1.0 / 3.0;
  flight_path.dropped_view_ids = {3, 1};
  flight_path.drop_reasons = {"it is in unknown space", "no way"};
  flight_path.flights = {{0, 4, 100.5, 60, 10, 0.5}, {4, 6, 23, 20, 3.25, 0.25}};
  return flight_path;
}

TEST(ViewPlanIo, ViewsComeBack) {
  const TestFolder folder;
  const auto written = RandomViews(50);
  WriteViews(written, {.is_metric_enu = true, .origin = kOrigin}, folder / "views.json");
  const auto read = ReadViews(folder / "views.json");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].id, written[i].id);
    EXPECT_EQ(read[i].position, written[i].position);
    EXPECT_EQ(read[i].score, written[i].score);
    EXPECT_NEAR(read[i].direction.yaw_rad, written[i].direction.yaw_rad, 2e-15);
    EXPECT_NEAR(read[i].direction.pitch_rad, written[i].direction.pitch_rad, 1e-15);
  }
}

TEST(ViewPlanIo, LatitudeAndLongitudeAreThereWhenTheFrameHasAnOrigin) {
  const TestFolder folder;
  const auto views = RandomViews(3);
  WriteViews(views, {.is_metric_enu = true, .origin = kOrigin}, folder / "geo.json");
  const Json geo = ReadJsonFile(folder / "geo.json");
  for (std::size_t i = 0; i < views.size(); ++i) {
    const GeoPosition position{geo[i]["lat"], geo[i]["lon"], geo[i]["height_m"]};
    EXPECT_LT((EnuFromGeo(kOrigin, position) - views[i].position).norm(), 1e-6);
  }
  WriteViews(views, {.is_metric_enu = true, .origin = {}}, folder / "local.json");
  EXPECT_FALSE(ReadJsonFile(folder / "local.json")[0].contains("lat"));
  EXPECT_EQ(ReadViews(folder / "local.json").size(), views.size());
}

TEST(ViewPlanIo, NoViewsAreAnEmptyList) {
  const TestFolder folder;
  WriteViews({}, {}, folder / "views.json");
  EXPECT_EQ(ReadFile(folder / "views.json"), "[]\n");
  EXPECT_TRUE(ReadViews(folder / "views.json").empty());
}

TEST(ViewPlanIo, APathComesBack) {
  const TestFolder folder;
  const FlightPath written = RandomPath();
  WritePath(written, {.is_metric_enu = true, .origin = kOrigin}, folder / "path.json");
  const FlightPath read = ReadPath(folder / "path.json");
  ASSERT_EQ(read.waypoints.size(), written.waypoints.size());
  for (std::size_t i = 0; i < read.waypoints.size(); ++i) {
    EXPECT_EQ(read.waypoints[i].position, written.waypoints[i].position);
    EXPECT_EQ(read.waypoints[i].view_id, written.waypoints[i].view_id);
    EXPECT_NEAR(read.waypoints[i].direction.yaw_rad, written.waypoints[i].direction.yaw_rad, 2e-15);
  }
  EXPECT_EQ(read.length_m, written.length_m);
  EXPECT_EQ(read.duration_s, written.duration_s);
  EXPECT_EQ(read.min_clearance_m, written.min_clearance_m);
  EXPECT_EQ(read.dropped_view_ids, written.dropped_view_ids);
  EXPECT_EQ(read.drop_reasons, written.drop_reasons);
  ASSERT_EQ(read.flights.size(), 2u);
  EXPECT_EQ(read.flights[1].first_waypoint, 4u);
  EXPECT_EQ(read.flights[1].last_waypoint, 6u);
  EXPECT_EQ(read.flights[1].length_m, 23);
  EXPECT_EQ(read.flights[0].duration_s, 60);
  EXPECT_EQ(read.flights[1].return_s, 3.25);
  EXPECT_EQ(read.flights[0].battery_share, 0.5);
}

// Paths of earlier versions have neither flights nor reasons.
TEST(ViewPlanIo, APathMayLackFlightsButNotNameWaypointsThatAreNotThere) {
  const TestFolder folder;
  WritePath(RandomPath(), {.is_metric_enu = true, .origin = kOrigin}, folder / "path.json");
  Json json = ReadJsonFile(folder / "path.json");
  json["flights"][1]["last_waypoint"] = 7;
  WriteJsonFile(json, folder / "wrong.json");
  ExpectError([&] { ReadPath(folder / "wrong.json"); },
              {"wrong.json", "/flights/1/last_waypoint", "no such waypoint"});
  json.erase("flights");
  json.erase("drop_reasons");
  WriteJsonFile(json, folder / "old.json");
  EXPECT_TRUE(ReadPath(folder / "old.json").flights.empty());
}

// An infinite clearance must not turn into "null" in the file.
TEST(ViewPlanIo, ANumberThatIsNotFiniteIsNotWritten) {
  const TestFolder folder;
  FlightPath flight_path = RandomPath();
  flight_path.min_clearance_m = std::numeric_limits<double>::infinity();
  ExpectError([&] { WritePath(flight_path, {}, folder / "path.json"); },
              {"path.json: /min_clearance_m", "not finite"});
  flight_path = RandomPath();
  flight_path.waypoints[2].position.y() = std::numeric_limits<double>::quiet_NaN();
  ExpectError(
      [&] {
        WritePath(flight_path, {.is_metric_enu = true, .origin = kOrigin}, folder / "path.json");
      },
      {"/waypoints/2/position_enu_m/1"});
  EXPECT_FALSE(std::filesystem::exists(folder / "path.json"));
}

TEST(ViewPlanIo, BadViewsAreNamedByTheirPointer) {
  const TestFolder folder;
  const std::string good =
      R"([{"id":1,"position_enu_m":[1,2,3],"yaw_deg":0,"pitch_deg":0,"score":1}])";
  const auto expect = [&](const std::string& from, const std::string& to,
                          const std::string& message) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    WriteFileAtomically(folder / "v.json", text);
    ExpectError([&] { ReadViews(folder / "v.json"); }, {"v.json", message});
  };
  WriteFileAtomically(folder / "v.json", good);
  EXPECT_EQ(ReadViews(folder / "v.json").size(), 1U);
  expect("\"id\":1", "\"id\":1.5", "/0/id: expected a whole number");
  expect("\"id\":1", "\"id\":1e300", "/0/id: expected a whole number");
  expect("\"id\":1", "\"id\":\"1\"", "/0/id: expected a number, found string");
  expect("\"id\":1,", "", "/0: \"id\" is missing");
  expect("[1,2,3]", "[1,2]", "/0/position_enu_m: expected three numbers");
  expect("[1,2,3]", "[1,2,null]", "/0/position_enu_m/2: expected a number, found null");
  expect("\"score\":1", "\"score\":1e999", "v.json");
  expect("}]", "}", "not valid JSON");
  expect("[{", "{", "not valid JSON");
  WriteFileAtomically(folder / "v.json", "[" + good.substr(1, good.size() - 2) + "," +
                                             good.substr(1, good.size() - 2) + "]");
  ExpectError([&] { ReadViews(folder / "v.json"); }, {"/1/id: id 1 occurs twice"});
  WriteFileAtomically(folder / "v.json", "{}");
  ExpectError([&] { ReadViews(folder / "v.json"); }, {"top level: expected an array"});
  WriteFileAtomically(folder / "p.json", R"({"waypoints":[]})");
  ExpectError([&] { ReadPath(folder / "p.json"); }, {"p.json", "\"length_m\" is missing"});
}

TEST(JsonFile, PointersEscapeKeysAndAccessorsCheckTypes) {
  const TestFolder folder;
  WriteFileAtomically(folder / "a.json", R"({"a/b~c": true, "text": "x", "n": 2})");
  const Json json = ReadJsonFile(folder / "a.json");
  const JsonNode root(json, "a.json");
  EXPECT_TRUE(root["a/b~c"].Boolean());
  EXPECT_EQ(root["text"].Text(), "x");
  EXPECT_EQ(root["n"].Integer(), 2);
  EXPECT_FALSE(root.Find("other").has_value());
  ExpectError([&] { root["a/b~c"].Number(); }, {"/a~1b~0c", "expected a number, found boolean"});
  ExpectError([&] { root["n"].Text(); }, {"a.json: /n", "expected a text"});
  ExpectError([&] { root["n"].Boolean(); }, {"/n", "expected true or false"});
  ExpectError([&] { root["n"]["x"]; }, {"/n", "expected an object"});
  Json bad;
  bad["name"] = "\xFF";
  ExpectError([&] { WriteJsonFile(bad, folder / "b.json"); }, {"b.json"});
}

TEST(WorldFrame, ComesBackWithAndWithoutOrigin) {
  const TestFolder folder;
  WriteWorldFrame({.is_metric_enu = true, .origin = kOrigin}, folder / "frame.json");
  const WorldFrame geo = ReadWorldFrame(folder / "frame.json");
  EXPECT_TRUE(geo.is_metric_enu);
  ASSERT_TRUE(geo.origin.has_value());
  EXPECT_EQ(geo.origin->lat_deg, kOrigin.lat_deg);
  EXPECT_EQ(geo.origin->lon_deg, kOrigin.lon_deg);
  EXPECT_EQ(geo.origin->height_m, kOrigin.height_m);
  WriteWorldFrame({.is_metric_enu = true, .origin = {}}, folder / "frame.json");
  EXPECT_TRUE(ReadWorldFrame(folder / "frame.json").is_metric_enu);
  EXPECT_FALSE(ReadWorldFrame(folder / "frame.json").origin.has_value());
  WriteWorldFrame({}, folder / "frame.json");
  EXPECT_FALSE(ReadWorldFrame(folder / "frame.json").is_metric_enu);
}

TEST(WorldFrame, BadFramesAreRefused) {
  const TestFolder folder;
  const auto expect = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(folder / "f.json", text);
    ExpectError([&] { ReadWorldFrame(folder / "f.json"); }, {"f.json", message});
  };
  expect("{}", "\"metric\" is missing");
  expect(R"({"metric": 1})", "/metric: expected true or false");
  expect(R"({"metric": true, "origin": {"lat": 91, "lon": 0, "height_m": 0}})", "/origin");
  expect(R"({"metric": true, "origin": {"lat": 9, "lon": 0}})", "/origin: \"height_m\" is missing");
  expect(R"({"metric": false, "origin": {"lat": 9, "lon": 0, "height_m": 0}})", "/metric");
  ExpectError(
      [&] {
        WriteWorldFrame({.is_metric_enu = true, .origin = GeoPosition{95, 0, 0}},
                        folder / "g.json");
      },
      {"g.json"});
}

TEST(CoverageSummary, HasTheNamesThatOtherProgramsRead) {
  const TestFolder folder;
  CoverageMap map;
  map.disk_area_m2 = 0.25;
  map.min_projection_ratio = 400;
  map.points.resize(5);
  map.points[0].coverage = map.points[1].coverage = map.points[2].coverage =
      CoverageClass::kCovered;
  map.points[4].coverage = CoverageClass::kIgnored;
  WriteCoverageSummary(map, {{"max_angle_deg", 30}}, folder / "coverage.json");
  const Json json = ReadJsonFile(folder / "coverage.json");
  EXPECT_EQ(json["covered"], 3);
  EXPECT_EQ(json["uncovered"], 1);
  EXPECT_EQ(json["ignored"], 1);
  EXPECT_EQ(json["covered_ratio"], 0.75);
  EXPECT_EQ(json["area_m2"], 1.0);
  EXPECT_EQ(json["thresholds"]["min_projection_ratio"], 400);
  EXPECT_EQ(json["thresholds"]["max_angle_deg"], 30);
}

}  // namespace
}  // namespace colmap_ext
