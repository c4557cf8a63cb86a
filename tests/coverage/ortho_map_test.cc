#include "colmap_ext/coverage/ortho_map.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/util/files.h"
#include "coverage/test_scene.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

const RegionOfInterest kRegion{
    BoundingBox(Eigen::Vector3d(-10, -5, -1), Eigen::Vector3d(10, 5, 20))};

// Ground in the southern half of the region, and a roof of 4 x 2 m at 6 m in its north-eastern
// corner.
Surface GroundAndRoof() {
  Surface surface;
  AppendPanel({-10, -5, 0}, {20, 0, 0}, {0, 5, 0}, 20, &surface.mesh);
  AppendPanel({6, 3, 6}, {4, 0, 0}, {0, 2, 0}, 10, &surface.mesh);
  return surface;
}

// Iso-points every metre: the western ground covered, the eastern one not, the roof ignored.
CoverageMap ThreeClasses() {
  CoverageMap map;
  map.disk_area_m2 = 1;
  const auto add = [&map](const Eigen::Vector3d& position, CoverageClass coverage, double error) {
    IsoPoint point;
    point.position = position;
    point.normal = Eigen::Vector3d::UnitZ();
    point.coverage = coverage;
    point.predicted_error_mm = error;
    map.points.push_back(point);
  };
  for (int x = -10; x < 10; ++x) {
    for (int y = -5; y < 0; ++y) {
      add({x + 0.5, y + 0.5, 0}, x < 0 ? CoverageClass::kCovered : CoverageClass::kUncovered,
          x < 0 ? 5 : -1);
    }
  }
  for (int x = 6; x < 10; ++x) add({x + 0.5, 4, 6}, CoverageClass::kIgnored, 50);
  return map;
}

OrthoMap Render(const std::string& colors) {
  OrthoMapOptions options;
  options.pixel_size_m = 0.25;
  options.colors = colors;
  return RenderOrthoMap(GroundAndRoof(), ThreeClasses(), kRegion, options);
}

// The pixel of a place.
cv::Vec4b At(const OrthoMap& map, double x, double y) {
  return map.bgra.at<cv::Vec4b>(static_cast<int>((map.upper_left.y() - y) / map.pixel_size_m),
                                static_cast<int>((x - map.upper_left.x()) / map.pixel_size_m));
}

int Strongest(const cv::Vec4b& pixel) {
  return static_cast<int>(std::max_element(pixel.val, pixel.val + 3) - pixel.val);
}

TEST(OrthoMap, ShowsTheClassesNorthUp) {
  const OrthoMap map = Render("class");
  EXPECT_EQ(map.bgra.size(), cv::Size(80, 40));
  EXPECT_EQ(Strongest(At(map, -5, -2)), 1) << "covered is green";
  EXPECT_EQ(Strongest(At(map, 5, -2)), 2) << "uncovered is red";
  EXPECT_EQ(Strongest(At(map, 8, 4)), 0) << "ignored is blue";
  EXPECT_EQ(At(map, 8, 4)[3], 255);
  EXPECT_EQ(At(map, -5, 3), cv::Vec4b(0, 0, 0, 0)) << "no surface";
}

TEST(OrthoMap, ShowsThePredictedError) {
  const OrthoMap map = Render("error");
  const auto lightness = [](const cv::Vec4b& pixel) { return pixel[0] + pixel[1] + pixel[2]; };
  EXPECT_LT(lightness(At(map, -5, -2)), lightness(At(map, 5, -2)));
  EXPECT_EQ(Strongest(At(map, 8, 4)), 0) << "what is ignored has no error";
}

TEST(OrthoMap, AutomaticSizeHasAThousandPixels) {
  const OrthoMap map = RenderOrthoMap(GroundAndRoof(), ThreeClasses(), kRegion, {});
  EXPECT_EQ(map.bgra.size(), cv::Size(1000, 500));
}

TEST(OrthoMap, BadOptionsAreRefused) {
  OrthoMapOptions options;
  options.pixel_size_m = 1e-5;
  ExpectError([&] { RenderOrthoMap(GroundAndRoof(), ThreeClasses(), kRegion, options); },
              {"pixel_size_m"});
  options = {};
  options.colors = "pretty";
  ExpectError([&] { RenderOrthoMap(GroundAndRoof(), ThreeClasses(), kRegion, options); },
              {"OrthoMap.colors"});
}

std::vector<double> NumbersIn(const std::filesystem::path& path) {
  std::istringstream stream(ReadFile(path));
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  return numbers;
}

TEST(OrthoMap, LocalWorldFilePlacesPixelCentres) {
  const TestFolder folder;
  WriteFileAtomically(folder / "map.prj", std::string("of an earlier map"));
  WriteOrthoMap(Render("class"), {true, std::nullopt}, folder / "map.png");
  const std::vector<double> numbers = NumbersIn(folder / "map.pgw");
  const std::vector<double> expected = {0.25, 0, 0, -0.25, -9.875, 4.875};
  EXPECT_EQ(numbers, expected);
  EXPECT_FALSE(std::filesystem::exists(folder / "map.prj"));
  const cv::Mat picture = cv::imread((folder / "map.png").string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(picture.type(), CV_8UC4);
  EXPECT_EQ(picture.size(), cv::Size(80, 40));
}

// Any pixel, through the world file, lands where its place on Earth is.
void ExpectPlacedOnEarth(const GeoPosition& origin, const std::string& zone_name,
                         const std::string& epsg) {
  const TestFolder folder;
  const OrthoMap map = Render("class");
  WriteOrthoMap(map, {true, origin}, folder / "map.png");
  const std::vector<double> w = NumbersIn(folder / "map.pgw");
  ASSERT_EQ(w.size(), 6U);
  for (const int col : {0, 17, 79}) {
    for (const int row : {0, 39}) {
      const Eigen::Vector3d enu(-10 + 0.25 * (col + 0.5), 5 - 0.25 * (row + 0.5), 0);
      const UtmPosition utm = UtmFromGeo(GeoFromEnu(origin, enu), UtmZoneOf(origin));
      EXPECT_NEAR(w[0] * col + w[2] * row + w[4], utm.easting_m, 1e-3);
      EXPECT_NEAR(w[1] * col + w[3] * row + w[5], utm.northing_m, 1e-3);
    }
  }
  const std::string wkt = ReadFile(folder / "map.prj");
  EXPECT_NE(wkt.find(zone_name), std::string::npos) << wkt;
  EXPECT_NE(wkt.find("\"EPSG\",\"" + epsg + "\""), std::string::npos) << wkt;
}

TEST(OrthoMap, OnEarthTheWorldFileIsUtm) {
  ExpectPlacedOnEarth({47.3977, 8.5456, 488}, "UTM zone 32N", "32632");
  ExpectPlacedOnEarth({-33.86, 151.2, 20}, "UTM zone 56S", "32756");
}

TEST(OrthoMap, NearThePolesItIsLocal) {
  const TestFolder folder;
  WriteOrthoMap(Render("class"), {true, GeoPosition{89, 10, 0}}, folder / "map.png");
  EXPECT_EQ(NumbersIn(folder / "map.pgw").front(), 0.25);
  EXPECT_FALSE(std::filesystem::exists(folder / "map.prj"));
}

TEST(Utm, AgreesWithKnownPositions) {
  // The central meridian of zone 32 at the equator, and a survey mark: Munich, Frauenkirche.
  const UtmPosition middle = UtmFromGeo({0, 9, 0}, 32);
  EXPECT_NEAR(middle.easting_m, 500000, 1e-6);
  EXPECT_NEAR(middle.northing_m, 0, 1e-6);
  EXPECT_EQ(UtmZoneOf({48.1386, 11.5736, 0}), 32);
  const UtmPosition munich = UtmFromGeo({48.1386, 11.5736, 0}, 32);
  EXPECT_NEAR(munich.easting_m, 691500, 300);
  EXPECT_NEAR(munich.northing_m, 5334700, 300);
  EXPECT_EQ(UtmZoneOf({89, 10, 0}), 0);
}

}  // namespace
}  // namespace colmap_ext
