// The coverage of any model: a sparse model of COLMAP with a mesh or a cloud of any program.
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/util/files.h"
#include "small_site.h"

namespace colmap_ext {
namespace {

class CoverageOfAnyModel : public SmallSite {
 protected:
  // Points of the floor and of the box's top, a grid of 0.1 m, without normals.
  void WriteCloud(const std::filesystem::path& path) const {
    TriangleMesh cloud;
    for (double x = -4; x <= 4; x += 0.1) {
      for (double y = -4; y <= 4; y += 0.1) {
        const bool is_top = std::abs(x) < 1.5 && std::abs(y) < 1.5;
        cloud.vertices.emplace_back(x, y, is_top ? 2.5 : 0.0);
      }
    }
    WriteMesh(cloud, path);
  }

  void WriteTop(const std::filesystem::path& path) const {
    TriangleMesh top;
    top.vertices = {{-1.5, -1.5, 2.5}, {1.5, -1.5, 2.5}, {1.5, 1.5, 2.5}, {-1.5, 1.5, 2.5}};
    top.faces = {{0, 1, 2}, {0, 2, 3}};
    WriteMesh(top, path);
  }

  ChildProcessResult Evaluate(const std::string& mesh, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {
        "coverage_evaluator",      "--input_path",  (folder_ / "sparse").string(), "--mesh_path",
        (folder_ / mesh).string(), "--output_path", (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
};

TEST_F(CoverageOfAnyModel, ACloudWithoutNormalsIsJudged) {
  WriteCloud(folder_ / "cloud.ply");
  const ChildProcessResult result =
      Evaluate("cloud.ply", {"--RegionOfInterest.box", "-3,-3,-0.5,3,3,3"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("no normals"), std::string::npos) << result.output;
  const CoverageMap map = ReadCoverageMap(folder_ / "out" / "coverage.ply");
  EXPECT_GT(map.points.size(), 1000U);
  std::size_t up = 0;
  for (const IsoPoint& point : map.points) up += point.normal.z() > 0.5;
  EXPECT_GT(up, map.points.size() * 6 / 10) << "floor and top face the photos above";
  const Json summary = ReadJsonFile(folder_ / "out" / "coverage.json");
  EXPECT_GT(summary["predicted_error_mm"]["median"].get<double>(), 0);
}

TEST_F(CoverageOfAnyModel, AMeshIsJudgedAndMapped) {
  WriteTop(folder_ / "top.ply");
  WriteFileAtomically(
      folder_ / "half.geojson",
      std::string(R"({"type":"Polygon","coordinates":[[[-5,-5],[0,-5],[0,5],[-5,5]]]})"));
  const ChildProcessResult result = Evaluate(
      "top.ply", {"--RegionOfInterest.box", "-2,-2,2,2,2,3", "--RegionOfInterest.polygon_path",
                  (folder_ / "half.geojson").string(), "--OrthoMap.pixel_size_m", "0.1"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const IsoPoint& point : ReadCoverageMap(folder_ / "out" / "coverage.ply").points) {
    EXPECT_EQ(point.coverage == CoverageClass::kIgnored, point.position.x() > 0);
  }
  const cv::Mat map = cv::imread((folder_ / "out" / "coverage_map.png").string(), -1);
  EXPECT_EQ(map.size(), cv::Size(20, 40)) << "the polygon's half of the box";
  EXPECT_EQ(ReadFile(folder_ / "out" / "coverage_map.pgw").substr(0, 4), "0.1\n");
}

TEST_F(CoverageOfAnyModel, TheFrameOfTheModelPlacesTheMapOnEarth) {
  WriteTop(folder_ / "top.ply");
  // As sparse_updater writes it: in the folder of the model.
  WriteFileAtomically(folder_ / "sparse" / "frame.json",
                      std::string(R"({"metric": true, "origin": {"lat": 46.5, "lon": 6.6,
                                      "height_m": 400}})"));
  const ChildProcessResult result =
      Evaluate("top.ply", {"--RegionOfInterest.box", "-2,-2,2,2,2,3"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(ReadFile(folder_ / "out" / "coverage_map.prj").find("UTM"), std::string::npos);
}

TEST_F(CoverageOfAnyModel, ARegionWithNothingInItIsSaid) {
  WriteTop(folder_ / "top.ply");
  const ChildProcessResult result =
      Evaluate("top.ply", {"--RegionOfInterest.box", "100,100,0,110,110,3"});
  EXPECT_NE(result.output.find("nothing was judged"), std::string::npos) << result.output;
}

TEST_F(CoverageOfAnyModel, AWantedErrorDecides) {
  WriteTop(folder_ / "top.ply");
  const auto covered_with_target = [this](const std::string& target_mm) {
    const ChildProcessResult result = Evaluate(
        "top.ply",
        {"--RegionOfInterest.box", "-2,-2,2,2,2,3", "--Coverage.target_error_mm", target_mm});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return ReadJsonFile(folder_ / "out" / "coverage.json")["covered"].get<int>();
  };
  EXPECT_EQ(covered_with_target("0.001"), 0);
  EXPECT_GT(covered_with_target("10000"), 1000);
}

TEST_F(CoverageOfAnyModel, ACrookedPolygonIsRefused) {
  WriteTop(folder_ / "top.ply");
  WriteFileAtomically(folder_ / "bad.geojson", std::string("{\"type\":\"Polygon\"}"));
  ExpectFailure(
      Evaluate("top.ply", {"--RegionOfInterest.polygon_path", (folder_ / "bad.geojson").string()}),
      1, {"bad.geojson", "coordinates"});
}

}  // namespace
}  // namespace colmap_ext
