#include "colmap_ext/scene/position_file.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

TEST(GeoFile, NamesLongitudeLatitudeAltitudeAreRead) {
  const TestFolder folder;
  WriteFileAtomically(folder / "geo.txt",
                      "# positions\r\n\r\na.jpg -116.405 33.627 1044.5\r\n"
                      "sub/b.jpg\t8.5  47.25 -3 1 2 3 0.5 0.5");
  const auto positions = ReadGeoFile(folder / "geo.txt");
  ASSERT_EQ(positions.size(), 2U);
  EXPECT_EQ(positions.at("a.jpg").lon_deg, -116.405);
  EXPECT_EQ(positions.at("a.jpg").lat_deg, 33.627);
  EXPECT_EQ(positions.at("a.jpg").height_m, 1044.5);
  EXPECT_EQ(positions.at("sub/b.jpg").height_m, -3);
}

TEST(GeoFile, OpenDroneMapsHeaderAndCommasAreUnderstood) {
  const TestFolder folder;
  WriteFileAtomically(folder / "geo.txt", "EPSG:4326\na.jpg 8 47 400\n");
  EXPECT_EQ(ReadGeoFile(folder / "geo.txt").at("a.jpg").lat_deg, 47);
  WriteFileAtomically(folder / "geo.txt", "\xEF\xBB\xBFmy photo 1.jpg, 8, 47, 400\n");
  EXPECT_EQ(ReadGeoFile(folder / "geo.txt").at("my photo 1.jpg").height_m, 400);
}

TEST(GeoFile, BadLinesAreNamed) {
  const TestFolder folder;
  const auto expect = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(folder / "geo.txt", text);
    ExpectError([&] { ReadGeoFile(folder / "geo.txt"); }, {"geo.txt", message});
  };
  expect("a.jpg 8 47 400\nb.jpg 8 47\n", "line 2: expected 'name lon lat alt'");
  expect("a.jpg 8 47 high\n", "line 1: 'high' is no number");
  expect("a.jpg 8 47 nan\n", "line 1: 'nan' is no number");
  expect("\na.jpg 8 97 400\n", "line 2: longitude or latitude is out of range");
  expect("a.jpg 8 47 400\na.jpg 8 47 401\n", "line 2: photo a.jpg is named twice");
  expect("EPSG:32616\na.jpg 500000 5000000 400\n", "line 1: coordinate system EPSG:32616");
  expect("WGS84 UTM 16N\na.jpg 500000 5000000 400\n", "line 1: coordinate system WGS84");
  expect("# nothing\n", "no line names a photo");
  expect("EPSG:4326\n", "no line names a photo");
  expect("a.jpg,,47,400\n", "line 1: '' is no number");
}

TEST(PosePriorFile, ComesBackToTheLastBit) {
  const TestFolder folder;
  const std::map<std::string, Eigen::Vector3d> written = {{"a.jpg", {0.1, -1.0 / 3, 1e-9}},
                                                          {"two words.jpg", {1e6, 2, 3}}};
  WritePosePriorFile(written, folder / "poses.txt");
  EXPECT_EQ(ReadPosePriorFile(folder / "poses.txt"), written);
  ExpectError(
      [&] {
        WritePosePriorFile({{"a,b", {1, 2, 3}}}, folder / "x.txt");
      },
      {"x.txt", "a,b"});
}

TEST(PosePriorFile, BadLinesAreNamed) {
  const TestFolder folder;
  const auto expect = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(folder / "p.txt", text);
    ExpectError([&] { ReadPosePriorFile(folder / "p.txt"); }, {"p.txt", message});
  };
  expect("a.jpg 1 2\n", "line 1: expected 'name x y z'");
  expect("a.jpg 1 2 3 4\n", "line 1: expected 'name x y z'");
  expect("a.jpg 1 2 3\n\nb.jpg 1 x 3\n", "line 3: 'x' is no number");
  expect("a.jpg 1 2 3\na.jpg 1 2 3\n", "line 2: photo a.jpg is named twice");
}

}  // namespace
}  // namespace colmap_ext
