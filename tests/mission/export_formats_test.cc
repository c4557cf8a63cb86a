// Every format is read by something that is not ours: GDAL, unzip, xmllint.
#include "colmap_ext/mission/export_formats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mission/mission_world.h"

namespace colmap_ext {
namespace {

using Json = nlohmann::json;

MissionOptions Ellipsoidal(const std::string& undulation_m) {
  MissionOptions options;
  options.frame_heights = "ellipsoidal";
  options.geoid_undulation_m = undulation_m;
  return options;
}

std::size_t Count(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

bool Has(const std::string& text, const std::string& word) { return Count(text, word) > 0; }

TEST(PrepareMission, KnowsEveryHeightWithTheGeoid) {
  const Mission mission = MissionOf(Ellipsoidal("47"));
  EXPECT_NEAR(mission.stops[0].height.relative_m, 12, 1e-3);
  EXPECT_NEAR(*mission.stops[0].height.ellipsoidal_m, 462, 1e-3);
  EXPECT_NEAR(*mission.stops[0].height.amsl_m, 415, 1e-3);
  MissionOptions amsl = Ellipsoidal("47");
  amsl.frame_heights = "amsl";
  EXPECT_NEAR(*MissionOf(amsl).stops[0].height.ellipsoidal_m, 509, 1e-3);
  EXPECT_FALSE(MissionOf({}).stops[0].height.amsl_m.has_value());
}

TEST(PrepareMission, RefusesAbsoluteHeightsWithoutADatum) {
  MissionOptions options;
  options.height_reference = "amsl";
  EXPECT_THROW(MissionOf(options), Error);
  options.frame_heights = "amsl";
  EXPECT_NO_THROW(MissionOf(options));
  options.height_reference = "sideways";
  EXPECT_THROW(MissionOf(options), UsageError);
  options = Ellipsoidal("a lot");
  EXPECT_THROW(MissionOf(options), UsageError);
}

TEST(PathOfFlight, TakesOneBatterysPart) {
  FlightPath path = TwoViewsAndATurn();
  path.flights = {{0, 1, 30, 20, 5, 0.3}, {1, 2, 36, 20, 5, 0.4}};
  const FlightPath second = PathOfFlight(path, 1);
  ASSERT_EQ(second.waypoints.size(), 2u);
  EXPECT_EQ(second.waypoints[1].view_id, 8);
  EXPECT_EQ(second.flights[0].last_waypoint, 1u);
  EXPECT_THROW(PathOfFlight(path, 2), Error);
}

TEST(SetFence, PutsZonesOnEarth) {
  FlightZone fence, school;
  fence.rings = {{{-50, -50}, {50, -50}, {50, 50}}, {{-1, -20}, {1, -20}, {0, -18}}};
  school.kind = FlightZone::Kind::kExclusion;
  school.rings = {{{0, 0}, {5, 0}, {5, 5}}};
  MissionOptions options;
  SetFence({.zones = {fence, school}}, FrameOnEarth(), &options);
  ASSERT_EQ(options.fence.size(), 1u);
  ASSERT_EQ(options.no_fly.size(), 2u);  // the hole of the fence, and the school
  EXPECT_NEAR(options.fence[0][0].lat_deg, 47.4 - 50 / 111180.0, 1e-5);
  EXPECT_THROW(SetFence({}, WorldFrame{true, std::nullopt}, &options), Error);
}

TEST(Wpl110, HasTwelveColumnsARowInOrder) {
  MissionOptions options;
  const std::vector<std::string> rows = Split(Wpl110(MissionOf(options), options), '\n');
  EXPECT_EQ(rows[0], "QGC WPL 110");
  std::vector<int> commands;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<std::string> columns = Split(rows[i], '\t');
    ASSERT_EQ(columns.size(), 12u) << rows[i];
    EXPECT_EQ(std::stoul(columns[0]), i - 1);
    EXPECT_EQ(columns[1], i == 1 ? "1" : "0");
    commands.push_back(std::stoi(columns[3]));
    for (std::size_t k = 4; k < 11; ++k) EXPECT_TRUE(std::isfinite(std::stod(columns[k])));
  }
  EXPECT_EQ(commands, (std::vector<int>{22, 178, 16, 1000, 16, 2000, 93, 1000, 16, 2000, 93, 20}));
  const std::vector<std::string> view = Split(rows[5], '\t');
  EXPECT_EQ(view[2], "3");
  EXPECT_NEAR(std::stod(view[7]), 270, 1e-6);
  EXPECT_NEAR(std::stod(view[8]), 47.4 + 20 / 111180.0, 1e-5);
  EXPECT_NEAR(std::stod(view[10]), 15, 1e-3);
}

TEST(Wpl110, BeginsWithHomeForArduPilotAndTakesHeightsAboveTheSea) {
  MissionOptions options = Ellipsoidal("47");
  options.autopilot = "ardupilot";
  options.height_reference = "amsl";
  const std::vector<std::string> rows = Split(Wpl110(MissionOf(options), options), '\n');
  const std::vector<std::string> home = Split(rows[1], '\t');
  EXPECT_EQ(home[3], "16");
  EXPECT_NEAR(std::stod(home[10]), 403, 1e-3);
  EXPECT_EQ(Split(rows[4], '\t')[2], "0");  // AMSL frame
  EXPECT_NEAR(std::stod(Split(rows[4], '\t')[10]), 415, 1e-3);
  options.height_reference = "ellipsoidal";
  EXPECT_THROW(Wpl110(MissionOf(options), options), Error);
}

TEST_F(MissionFiles, LitchiIsReadByGdalAsCsv) {
  const MissionOptions options;
  WriteFileAtomically(folder_ / "litchi.csv", LitchiCsv(MissionOf(options), options));
  const std::string text = Output({"ogrinfo", "-al", "-q", (folder_ / "litchi.csv").string()});
  EXPECT_EQ(Count(text, "OGRFeature"), 3u) << text;
  for (const char* value :
       {"gimbalpitchangle (String) = -30.000", "heading(deg) (String) = 270.000",
        "altitude(m) (String) = 15.000", "actiontype2 (String) = 1", "actionparam1 (String) = 2000",
        "actiontype15 (String) = -1"}) {
    EXPECT_TRUE(Has(text, value)) << value << "\n" << text;
  }
  const std::vector<std::string> rows = Split(LitchiCsv(MissionOf(options), options), '\n');
  for (const std::string& row : rows) EXPECT_EQ(Split(row, ',').size(), 46u);
}

TEST(LitchiCsv, RefusesTooManyWaypointsAndOtherHeights) {
  MissionOptions options = Ellipsoidal("47");
  options.height_reference = "amsl";
  EXPECT_THROW(LitchiCsv(MissionOf(options), options), Error);
  FlightPath path = TwoViewsAndATurn();
  path.waypoints.resize(100, path.waypoints[1]);
  EXPECT_THROW(LitchiCsv(PrepareMission(path, FrameOnEarth(), {}), {}), Error);
}

TEST_F(MissionFiles, KmlIsReadByGdal) {
  MissionOptions options = Ellipsoidal("47");
  options.height_reference = "amsl";
  WriteFileAtomically(folder_ / "path.kml", Kml(MissionOf(options), options));
  Output({"xmllint", "--noout", (folder_ / "path.kml").string()});
  const std::string text = Output({"ogrinfo", "-al", "-q", (folder_ / "path.kml").string()});
  EXPECT_TRUE(Has(text, "LINESTRING Z (8.5 47.4 415,")) << text;
  EXPECT_TRUE(Has(text, "view 7")) << text;
  EXPECT_EQ(Count(text, "POINT Z"), 2u) << text;
  options.height_reference = "ellipsoidal";
  EXPECT_THROW(Kml(MissionOf(options), options), Error);
  EXPECT_TRUE(Has(Kml(MissionOf({}), {}), "relativeToGround"));
}

TEST_F(MissionFiles, GeoJsonIsReadByGdal) {
  WriteFileAtomically(folder_ / "path.geojson", GeoJson(MissionOf(Ellipsoidal("47"))));
  const std::string text = Output({"ogrinfo", "-al", "-q", (folder_ / "path.geojson").string()});
  EXPECT_TRUE(Has(text, "LINESTRING Z (8.5 47.4 462")) << text;
  EXPECT_TRUE(Has(text, "view_id (Integer) = 7")) << text;
  EXPECT_EQ(Count(text, "OGRFeature"), 3u) << text;
}

// The text of the first element of this name after `from`.
std::string Element(const std::string& xml, const std::string& name, std::size_t from = 0) {
  const std::string open = "<" + name + ">";
  const std::size_t begin = xml.find(open, from);
  if (begin == std::string::npos) return "(none)";
  const std::size_t end = xml.find("</" + name + ">", begin);
  return xml.substr(begin + open.size(), end - begin - open.size());
}

TEST_F(MissionFiles, DjiKmzIsReadByUnzipAndXmllint) {
  MissionOptions options = Ellipsoidal("47");
  options.height_reference = "ellipsoidal";
  const std::filesystem::path kmz = folder_ / "mission.kmz";
  WriteDjiKmz(DjiWpml(MissionOf(options), options), kmz);
  Output({"unzip", "-t", kmz.string()});
  Output({"unzip", "-q", "-o", kmz.string(), "-d", folder_.string()});
  for (const char* name : {"template.kml", "waylines.wpml"}) {
    Output({"xmllint", "--noout", (folder_ / "wpmz" / name).string()});
  }
  const std::string waylines = ReadFile(folder_ / "wpmz" / "waylines.wpml");
  EXPECT_EQ(Count(waylines, "<Placemark>"), 3u);
  EXPECT_EQ(Count(waylines, "takePhoto"), 2u);
  EXPECT_EQ(Element(waylines, "wpml:executeHeightMode"), "WGS84");
  EXPECT_EQ(Element(waylines, "wpml:executeHeight"), "462.000");
  EXPECT_EQ(Element(waylines, "wpml:gimbalPitchRotateAngle"), "-30.000");
  EXPECT_EQ(Element(waylines, "wpml:waypointHeadingAngle",
                    waylines.rfind("<wpml:waypointHeadingAngle>", waylines.find("takePhoto"))),
            "-90.000");
  EXPECT_EQ(Element(waylines, "coordinates").substr(0, 4), "8.50");
  // What the template calls EGM96 is above the sea.
  const std::string plan = ReadFile(folder_ / "wpmz" / "template.kml");
  EXPECT_EQ(Element(plan, "wpml:heightMode"), "EGM96");
  EXPECT_EQ(Element(plan, "wpml:height"), "415.000");
  EXPECT_EQ(Element(plan, "wpml:ellipsoidHeight"), "462.000");
  const std::string bytes = ReadFile(kmz);
  WriteDjiKmz(DjiWpml(MissionOf(options), options), kmz);
  EXPECT_EQ(ReadFile(kmz), bytes);  // the same every time
}

TEST(DjiWpml, PrefersRelativeHeightsAndRefusesWhatItCannotSay) {
  MissionOptions options;
  const DjiWayline wayline = DjiWpml(MissionOf(options), options);
  EXPECT_EQ(Element(wayline.waylines_wpml, "wpml:executeHeightMode"), "relativeToStartPoint");
  EXPECT_EQ(Element(wayline.waylines_wpml, "wpml:executeHeight"), "12.000");
  EXPECT_EQ(Element(wayline.waylines_wpml, "wpml:droneEnumValue"), "77");
  options.frame_heights = "amsl";
  options.height_reference = "amsl";
  EXPECT_THROW(DjiWpml(MissionOf(options), options), Error);
  FlightPath one = TwoViewsAndATurn();
  one.waypoints.resize(1);
  EXPECT_THROW(DjiWpml(PrepareMission(one, FrameOnEarth(), {}), {}), Error);
}

TEST_F(MissionFiles, AFileThatCannotBeWrittenIsAnError) {
  EXPECT_THROW(WriteDjiKmz({"a", "b"}, "/proc/no/such/mission.kmz"), Error);
}

TEST(MissionJson, HasEverything) {
  MissionOptions options = Ellipsoidal("47");
  options.fence = {{{47, 8, 0}, {48, 8, 0}, {48, 9, 0}}};
  const Json json = Json::parse(MissionJson(MissionOf(options), options));
  EXPECT_EQ(json.at("stops").size(), 3u);
  EXPECT_NEAR(json["stops"][1]["heading_deg"].get<double>(), 270, 1e-9);
  EXPECT_NEAR(json["stops"][1]["amsl_m"].get<double>(), 418, 1e-3);
  EXPECT_EQ(json["stops"][2]["view_id"], 8);
  EXPECT_EQ(json.at("undulation_m"), 47);
  EXPECT_EQ(json.at("fence")[0].size(), 3u);
  EXPECT_TRUE(Json::parse(MissionJson(MissionOf({}), {})).at("home").at("amsl_m").is_null());
}

}  // namespace
}  // namespace colmap_ext
