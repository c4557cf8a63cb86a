#include "colmap_ext/scene/flight_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

using Ring = std::vector<Eigen::Vector2d>;

Ring Square(double x, double y, double half) {
  return {{x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
}

FlightZone Zone(FlightZone::Kind kind, const Ring& ring) {
  FlightZone zone;
  zone.kind = kind;
  zone.rings = {ring};
  return zone;
}

// A fence in the shape of an L made of two overlapping squares, a tall no-fly zone and a low one.
FlightLimits Site() {
  FlightLimits limits;
  limits.zones.push_back(Zone(FlightZone::Kind::kInclusion, Square(0, 0, 20)));
  limits.zones.push_back(Zone(FlightZone::Kind::kInclusion, Square(30, 0, 15)));
  limits.zones.push_back(Zone(FlightZone::Kind::kExclusion, Square(-10, 0, 4)));
  limits.zones.push_back(Zone(FlightZone::Kind::kExclusion, Square(10, 10, 4)));
  limits.zones[2].name = "school";
  limits.zones[3].max_z_m = 25;
  limits.min_z_m = 2;
  limits.max_z_m = 60;
  return limits;
}

TEST(FlightLimits, WithoutZonesAllowEverything) {
  const FlightLimits limits;
  EXPECT_TRUE(limits.IsEmpty());
  EXPECT_TRUE(std::isinf(limits.Margin({1e6, -3, -50})));
  EXPECT_TRUE(limits.AllowsSegment({0, 0, 0}, {1e5, 0, 0}, 100));
  EXPECT_EQ(limits.WhyNot({0, 0, 0}), "");
}

TEST(FlightLimits, SayWhyAPlaceIsNotAllowed) {
  const FlightLimits limits = Site();
  EXPECT_FALSE(limits.IsEmpty());
  EXPECT_EQ(limits.WhyNot({0, 0, 10}), "");
  EXPECT_EQ(limits.WhyNot({40, 0, 10}), "");
  EXPECT_EQ(limits.WhyNot({0, 30, 10}), "outside the geofence");
  EXPECT_EQ(limits.WhyNot({-10, 0, 59}), "inside the no-fly zone 'school'");
  EXPECT_EQ(limits.WhyNot({10, 10, 20}), "inside the no-fly zone");
  EXPECT_EQ(limits.WhyNot({10, 10, 26}), "");  // above it
  EXPECT_EQ(limits.WhyNot({0, 0, 1}), "below the lowest altitude");
  EXPECT_EQ(limits.WhyNot({0, 0, 61}), "above the highest altitude");
  EXPECT_FALSE(limits.Allows({std::nan(""), 0, 10}));
}

TEST(FlightLimits, MarginIsTheRadiusOfAnAllowedBall) {
  const FlightLimits limits = Site();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> wide(-50, 60), unit(-1, 1);
  int allowed = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d point(wide(random), wide(random), wide(random));
    const double margin = limits.Margin(point);
    EXPECT_EQ(margin > 0, limits.WhyNot(point).empty());
    if (margin <= 0) continue;
    ++allowed;
    Eigen::Vector3d step(unit(random), unit(random), unit(random));
    step *= 0.999 * margin / step.norm();
    EXPECT_TRUE(limits.Allows(point + step)) << point.transpose();
    EXPECT_LE(std::abs(limits.Margin(point + step) - margin), step.norm() + 1e-9);
  }
  EXPECT_GT(allowed, 200);
}

TEST(FlightLimits, SegmentsAgreeWithSamplesAlongThem) {
  const FlightLimits limits = Site();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> xy(-25, 45), z(1, 50);
  int accepted = 0, refused = 0;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d from(xy(random), xy(random), z(random));
    const Eigen::Vector3d to(xy(random), xy(random), z(random));
    double least = 1e9;
    for (int k = 0; k <= 2000; ++k) {
      least = std::min(least, limits.Margin(from + k / 2000.0 * (to - from)));
    }
    const bool is_allowed = limits.AllowsSegment(from, to, 0.5);
    (is_allowed ? accepted : refused)++;
    if (is_allowed) {
      EXPECT_GE(least, 0.5);
    } else {
      EXPECT_LT(least, 0.53);
    }
  }
  EXPECT_GT(accepted, 30);
  EXPECT_GT(refused, 30);
}

TEST(FlightLimits, ConcaveOutlinesAndHolesCount) {
  FlightZone zone;
  zone.rings = {{{0, 0}, {10, 0}, {10, 10}, {5, 2}, {0, 10}}, Square(5, 1, 0.5)};
  EXPECT_TRUE(zone.Contains({1, 1, 0}));
  EXPECT_FALSE(zone.Contains({5, 5, 0}));  // in the notch
  EXPECT_FALSE(zone.Contains({5, 1, 0}));  // in the hole
  EXPECT_NEAR(zone.Depth({2, 0.25, 0}), 0.25, 1e-12);
}

class ReadFlightLimitsTest : public ::testing::Test {
 protected:
  FlightLimits Read(const std::string& text) {
    WriteFileAtomically(folder_ / "fence.geojson", text);
    return ReadFlightLimits(folder_ / "fence.geojson", frame_);
  }

  TestFolder folder_;
  WorldFrame frame_{true, GeoPosition{47.397742, 8.545594, 488.0}};
};

TEST_F(ReadFlightLimitsTest, ReadsFeaturesOnEarth) {
  const GeoPosition far = GeoFromEnu(*frame_.origin, {100, 50, 0});
  const std::string x = std::to_string(far.lon_deg), y = std::to_string(far.lat_deg);
  const std::string ring = "[[[8.545594,47.397742],[" + x + ",47.397742],[" + x + "," + y +
                           "],[8.545594," + y + "],[8.545594,47.397742]]]";
  const FlightLimits limits = Read(R"({"type":"FeatureCollection","features":[
    {"type":"Feature","properties":null,"geometry":{"type":"Polygon","coordinates":)" +
                                   ring + R"(}},
    {"type":"Feature","properties":{"fence":"exclusion","name":"mast","max_altitude_m":30},
     "geometry":{"type":"MultiPolygon","coordinates":[)" +
                                   ring + "," + ring + "]}}]}");
  ASSERT_EQ(limits.zones.size(), 3u);
  EXPECT_EQ(limits.zones[0].kind, FlightZone::Kind::kInclusion);
  ASSERT_EQ(limits.zones[0].rings[0].size(), 4u);  // the closing corner is dropped
  EXPECT_NEAR((limits.zones[0].rings[0][2] - Eigen::Vector2d(100, 50)).norm(), 0, 0.1);
  EXPECT_EQ(limits.zones[2].kind, FlightZone::Kind::kExclusion);
  EXPECT_EQ(limits.zones[2].name, "mast");
  EXPECT_EQ(limits.zones[2].max_z_m, 30);
  EXPECT_EQ(limits.WhyNot({50, 25, 20}), "inside the no-fly zone 'mast'");
  EXPECT_EQ(limits.WhyNot({50, 25, 40}), "");
}

TEST_F(ReadFlightLimitsTest, ReadsLocalMetres) {
  frame_.origin.reset();
  const FlightLimits limits =
      Read(R"({"type":"Polygon","frame":"enu_m","coordinates":[[[0,0],[6,0],[6,5],[0,5],[0,0]]]})");
  EXPECT_EQ(limits.WhyNot({3, 3, 1}), "");
  EXPECT_EQ(limits.WhyNot({7, 3, 1}), "outside the geofence");
}

TEST_F(ReadFlightLimitsTest, SaysWhatIsWrongAndWhere) {
  const auto feature = [&](const std::string& properties, const std::string& geometry) {
    Read(R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":)" + properties +
         R"(,"geometry":)" + geometry + "}]}");
  };
  const std::string square =
      R"({"type":"Polygon","coordinates":[[[8,47],[9,47],[9,48],[8,48],[8,47]]]})";
  ExpectError([&] { feature(R"({"fence":"maybe"})", square); },
              {"fence.geojson", "/features/0/properties/fence", "exclusion"});
  ExpectError([&] { feature(R"({"min_altitude_m":9,"max_altitude_m":8})", square); },
              {"/features/0/properties", "below max_altitude_m"});
  ExpectError([&] { feature("{}", R"({"type":"Point","coordinates":[8,47]})"); },
              {"/features/0/geometry/type", "Point"});
  ExpectError(
      [&] { feature("{}", R"({"type":"Polygon","coordinates":[[[8,47],[9,47],[8,47]]]})"); },
      {"/features/0/geometry/coordinates/0", "three corners"});
  ExpectError(
      [&] { feature("{}", R"({"type":"Polygon","coordinates":[[[8,95],[9,47],[9,48]]]})"); },
      {"coordinates/0/0", "longitude"});
  ExpectError([&] { Read(R"({"type":"FeatureCollection","features":[]})"); }, {"no polygon"});
  ExpectError([&] { Read(R"({"type":"Polygon")"); }, {"fence.geojson", "JSON"});
  frame_.origin.reset();
  ExpectError([&] { feature("{}", square); }, {"fence.geojson", "no origin", "enu_m"});
}

}  // namespace
}  // namespace colmap_ext
