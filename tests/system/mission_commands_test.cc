// flight_planner, path_planner and mission_exporter as a user runs them.
#include <gtest/gtest.h>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {
namespace {

class MissionCommands : public ProgramTest {
 protected:
  MissionCommands() {
    WriteWorldFrame({true, GeoPosition{47.4, 8.5, 450}}, folder_ / "frame.json");
  }

  std::string In(const std::string& name) const { return (folder_ / name).string(); }

  ChildProcessResult PlanPattern(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"flight_planner", "--views_path",  In("views.json"),
                                          "--output_path",  In("path.json"), "--frame_path",
                                          In("frame.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }

  ChildProcessResult Export(const std::string& format, const std::string& name,
                            std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"mission_exporter", "--input_path",   In("path.json"),
                                          "--frame_path",     In("frame.json"), "--output_path",
                                          In(name),           "--format",       format};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
};

TEST_F(MissionCommands, APatternBecomesAMissionInEveryFormat) {
  const ChildProcessResult planned =
      PlanPattern({"--RegionOfInterest.box=-10,-6,0,10,6,19", "--Pattern.name", "2-Circles",
                   "--Pattern.num_views", "60", "--Path.battery_s", "0"});
  ASSERT_EQ(planned.exit_code, 0) << planned.output;
  EXPECT_NE(planned.output.find("pilot vouches"), std::string::npos);
  EXPECT_EQ(ReadViews(folder_ / "views.json").size(), 60u);
  for (const auto& [format, name] :
       std::vector<std::pair<std::string, std::string>>{{"qgc_plan", "m.plan"},
                                                        {"wpl", "m.waypoints"},
                                                        {"dji_wpml", "m.kmz"},
                                                        {"litchi", "m.csv"},
                                                        {"kml", "m.kml"},
                                                        {"geojson", "m.geojson"},
                                                        {"json", "m.json"}}) {
    const ChildProcessResult result = Export(format, name);
    EXPECT_EQ(result.exit_code, 0) << format << ": " << result.output;
    EXPECT_GT(ReadFile(folder_ / name).size(), 1000u) << format;
  }
  ExpectFailure(Export("kml", "n.kml", {"--Mission.height_reference", "amsl"}), 1,
                {"frame_heights"});
  ExpectFailure(Export("punched_tape", "n"), 2, {"punched_tape", "qgc_plan"});
}

TEST_F(MissionCommands, SeveralBatteriesBecomeSeveralFiles) {
  const ChildProcessResult planned =
      PlanPattern({"--RegionOfInterest.box=-10,-6,0,10,6,19", "--Pattern.name", "rectangle-sparse",
                   "--Pattern.num_views", "130", "--Path.battery_s", "600"});
  ASSERT_EQ(planned.exit_code, 0) << planned.output;
  const std::size_t flights = ReadPath(folder_ / "path.json").flights.size();
  ASSERT_GE(flights, 2u);
  EXPECT_EQ(Export("qgc_plan", "m.plan").exit_code, 0);
  for (std::size_t i = 1; i <= flights; ++i) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / ("m_" + std::to_string(i) + ".plan"))) << i;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "m.plan"));
  EXPECT_EQ(Export("qgc_plan", "second.plan", {"--flight", "2"}).exit_code, 0);
  EXPECT_EQ(ReadFile(folder_ / "second.plan"), ReadFile(folder_ / "m_2.plan"));
  ExpectFailure(Export("qgc_plan", "x.plan", {"--flight", "99"}), 1, {"no number 99"});
}

TEST_F(MissionCommands, PatternsObeyTheFence) {
  WriteFileAtomically(folder_ / "fence.geojson", R"({"type": "Feature", "frame": "enu_m",
      "properties": {"name": "yard"}, "geometry": {"type": "Polygon", "coordinates":
      [[[-30, -30], [30, -30], [30, 0], [-30, 0], [-30, -30]]]}})");
  const std::vector<std::string> pattern = {"--RegionOfInterest.box=-10,-6,0,10,6,19",
                                            "--Path.limits_path", In("fence.geojson"),
                                            "--Pattern.num_views", "64"};
  const ChildProcessResult planned = PlanPattern(pattern);
  ASSERT_EQ(planned.exit_code, 0) << planned.output;
  EXPECT_NE(planned.output.find("is left out"), std::string::npos) << planned.output;
  for (const PlannedView& view : ReadViews(folder_ / "views.json")) {
    EXPECT_LE(view.position.y(), 0) << view.id;
  }
  ASSERT_EQ(Export("qgc_plan", "m.plan", {"--limits_path", In("fence.geojson")}).exit_code, 0);
  const Json plan = ReadJsonFile(folder_ / "m.plan");
  EXPECT_EQ(plan["geoFence"]["polygons"].size(), 1u);
}

TEST_F(MissionCommands, SayWhatIsMissing) {
  ExpectFailure(PlanPattern({}), 2, {"RegionOfInterest.box"});
  ExpectFailure(
      PlanPattern({"--RegionOfInterest.box=-10,-6,0,10,6,19", "--Pattern.name", "spiral"}), 2,
      {"grid-downward"});
  ExpectFailure(Export("qgc_plan", "m.plan"), 1, {"path.json"});
}

}  // namespace
}  // namespace colmap_ext
