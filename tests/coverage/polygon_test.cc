// The region of interest as a polygon of a GeoJSON file.
#include <gtest/gtest.h>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/scene/region_json.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

const GeoPosition kOrigin{47.3977, 8.5456, 488.0};

WorldFrame OnEarth() { return {true, kOrigin}; }
WorldFrame Local() { return {true, std::nullopt}; }

class PolygonFile : public testing::Test {
 protected:
  std::vector<PolygonRing> Read(const std::string& text, const WorldFrame& frame) {
    WriteFileAtomically(folder_ / "area.geojson", text);
    return ReadPolygon(folder_ / "area.geojson", frame);
  }

  TestFolder folder_;
};

std::string LonLat(const Eigen::Vector2d& enu) {
  const GeoPosition position = GeoFromEnu(kOrigin, {enu.x(), enu.y(), 0});
  char text[80];
  std::snprintf(text, sizeof text, "[%.12f,%.12f]", position.lon_deg, position.lat_deg);
  return text;
}

// L-shaped: the square [0, 20]² without its upper right quarter.
const PolygonRing kShape = {{0, 0}, {20, 0}, {20, 10}, {10, 10}, {10, 20}, {0, 20}};

TEST_F(PolygonFile, LongitudesAndLatitudesBecomeMetres) {
  std::string ring;
  for (const Eigen::Vector2d& corner : kShape) ring += LonLat(corner) + ",";
  ring += LonLat(kShape.front());
  const auto rings = Read(R"({"type":"FeatureCollection","features":[{"type":"Feature",
      "properties":{"name":"site"},"geometry":{"type":"Point","coordinates":[0,0]}},
      {"type":"Feature","properties":null,"geometry":{"type":"Polygon","coordinates":[[)" +
                              ring + "]]}}]}",
                          OnEarth());
  ASSERT_EQ(rings.size(), 1U);
  ASSERT_EQ(rings[0].size(), kShape.size());
  for (std::size_t i = 0; i < kShape.size(); ++i) {
    EXPECT_NEAR((rings[0][i] - kShape[i]).norm(), 0, 1e-4);  // the Earth is round
  }
}

TEST_F(PolygonFile, WithoutAPlaceOnEarthTheyAreMetres) {
  const auto rings = Read(
      R"({"type":"MultiPolygon","coordinates":[[[[0,0],[4,0],[4,4],[0,4],[0,0]],
          [[1,1],[3,1],[3,3],[1,3]]],[[[10,0],[12,0],[12,2]]]]})",
      Local());
  ASSERT_EQ(rings.size(), 3U);
  RegionOfInterest region{BoundingBox(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(12, 4, 5)), rings};
  EXPECT_TRUE(region.Contains({0.5, 2, 1}));
  EXPECT_FALSE(region.Contains({2, 2, 1})) << "a hole";
  EXPECT_TRUE(region.Contains({11.5, 0.5, 1}));
  EXPECT_FALSE(region.Contains({7, 2, 1})) << "between the polygons";
  EXPECT_FALSE(region.Contains({0.5, 2, 6})) << "above the box";
}

TEST_F(PolygonFile, MistakesAreNamed) {
  const auto expect = [this](const std::string& text, const std::string& word) {
    ExpectError([&] { Read(text, OnEarth()); }, {"area.geojson", word});
  };
  expect("{", "line");
  expect(R"({"type":"Point","coordinates":[8.5,47.4]})", "no Polygon");
  expect(R"({"type":"Polygon","coordinates":[[[8.5456,47.3977],[8.5457,47.3977]]]})",
         "/coordinates/0");
  expect(R"({"type":"Polygon","coordinates":[[[1,1],[1,1],[1,1]]]})", "100 km");
  // Latitude first, as people say it.
  expect(R"({"type":"Polygon","coordinates":[[[47.3977,8.5456],[47.3978,8.5456],
             [47.3978,8.5457]]]})",
         "longitude comes first");
  expect(R"({"type":"Polygon","coordinates":[[[8.5,147.4],[8.5,147.5],[8.6,147.4]]]})", "degrees");
  expect(R"({"type":"Polygon","coordinates":[[["a",1],[2,3],[4,6]]]})", "/coordinates/0/0/0");
}

PhotoSet PointsOfATower() {
  PhotoSet set;
  for (int i = 0; i < 400; ++i) {
    const double x = -30 + 0.3 * (i % 20) * 10, y = -30 + 3.0 * (i / 20);
    const bool on_tower = x > 0 && x < 10 && y > 0 && y < 10;
    set.points.push_back({{x, y, on_tower ? 25.0 : 0.0}, 1, {}});
  }
  return set;
}

TEST_F(PolygonFile, ItsHeightIsThatOfThePointsInIt) {
  RegionOptions options;
  options.polygon_path = folder_ / "area.geojson";
  Read(R"({"type":"Polygon","coordinates":[[[-5,-5],[15,-5],[15,15],[-5,15]]]})", Local());
  const RegionOfInterest tower = DefaultRegion(PointsOfATower(), Local(), options);
  EXPECT_NEAR(tower.box.min().z(), -1, 1e-9);  // a margin of 5 % of 20 m
  EXPECT_NEAR(tower.box.max().z(), 25 + 1 + 2.5, 1e-9);
  EXPECT_TRUE(tower.Contains({5, 5, 20}));
  EXPECT_FALSE(tower.Contains({16, 5, 20}));
  options.box = "0,-10,2,100,100,9";
  const RegionOfInterest both = DefaultRegion(PointsOfATower(), Local(), options);
  EXPECT_TRUE(both.Contains({5, 5, 5}));
  EXPECT_FALSE(both.Contains({-1, 5, 5})) << "outside the box";
  EXPECT_FALSE(both.Contains({16, 5, 5})) << "outside the polygon";
  options.box = "50,50,0,60,60,9";
  ExpectError([&] { DefaultRegion(PointsOfATower(), Local(), options); }, {"outside"});
}

TEST_F(PolygonFile, WithoutPointsInItItIsRefused) {
  RegionOptions options;
  options.polygon_path = folder_ / "area.geojson";
  Read(R"({"type":"Polygon","coordinates":[[[500,500],[510,500],[510,510]]]})", Local());
  ExpectError([&] { DefaultRegion(PointsOfATower(), Local(), options); },
              {"area.geojson", "0 sparse points"});
}

TEST_F(PolygonFile, ARegionComesBackFromJsonExactly) {
  const RegionOfInterest written{
      BoundingBox(Eigen::Vector3d(-1.0 / 3, 0, 0.1), Eigen::Vector3d(20, 20, 1e7 / 3)), {kShape}};
  WriteJsonFile(RegionToJson(written), folder_ / "region.json");
  const Json json = ReadJsonFile(folder_ / "region.json");
  const RegionOfInterest read = RegionFromJson(JsonNode(json, folder_ / "region.json"));
  EXPECT_EQ(read.box.min(), written.box.min());
  EXPECT_EQ(read.box.max(), written.box.max());
  EXPECT_EQ(read.rings, written.rings);
  const Json bad = {
      {"min_enu_m", {0, 0, 0}}, {"max_enu_m", {1, 1, 1}}, {"rings_enu_m", {{{1, 2}}}}};
  ExpectError([&] { RegionFromJson(JsonNode(bad, "r.json")); }, {"/rings_enu_m/0", "3 corners"});
}

}  // namespace
}  // namespace colmap_ext
