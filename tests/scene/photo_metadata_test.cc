#include "colmap_ext/scene/photo_metadata.h"

#include <gtest/gtest.h>

#include <cmath>
#include <exiv2/exiv2.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

std::string Picture(int width = 64, int height = 36, const std::string& extension = ".jpg") {
  std::vector<unsigned char> buffer;
  cv::imencode(extension, cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 120, 200)), buffer);
  return {buffer.begin(), buffer.end()};
}

// Writes a photo with the EXIF tags that a camera would have written, as Exiv2's texts.
void WriteWithTags(const std::filesystem::path& path, int width, int height,
                   const std::vector<std::pair<std::string, std::string>>& tags,
                   const std::string& xmp = "") {
  WriteFileAtomically(path, Picture(width, height));
  const auto image = Exiv2::ImageFactory::open(path.string());
  image->readMetadata();
  for (const auto& [key, text] : tags) image->exifData()[key] = text;
  if (!xmp.empty()) {
    image->setXmpPacket(xmp);
    image->writeXmpFromPacket(true);
  }
  image->writeMetadata();
}

std::vector<std::pair<std::string, std::string>> GpsTags() {
  return {{"Exif.GPSInfo.GPSLatitudeRef", "S"},  {"Exif.GPSInfo.GPSLatitude", "33/1 30/1 36/1"},
          {"Exif.GPSInfo.GPSLongitudeRef", "W"}, {"Exif.GPSInfo.GPSLongitude", "116/1 15/1 0/1"},
          {"Exif.GPSInfo.GPSAltitudeRef", "0"},  {"Exif.GPSInfo.GPSAltitude", "12345/100"}};
}

// DJI's XMP packet.
std::string GimbalXmp(const std::string& yaw, const std::string& pitch) {
  return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
         "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description "
         "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\" "
         "drone-dji:GimbalRollDegree=\"+0.00\" "
         "drone-dji:GimbalYawDegree=\"" +
         yaw + "\" drone-dji:GimbalPitchDegree=\"" + pitch + "\"/></rdf:RDF></x:xmpmeta>";
}

PhotoMetadata FullMetadata() {
  PhotoMetadata metadata;
  metadata.gps =
      GeoPosition{.lat_deg = -33.62759174, .lon_deg = 116.405611694, .height_m = 1044.498};
  metadata.focal_px = 47.123456;
  metadata.camera_make = kSimulatedMake;
  metadata.camera_model = kSimulatedModel;
  metadata.yaw_rad = -2.5;
  metadata.pitch_rad = -0.6;
  metadata.capture_time = "2024-02-29T23:59:58.125";
  return metadata;
}

TEST(PhotoMetadata, WhatIsWrittenComesBack) {
  const TestFolder folder;
  for (const std::string extension : {".jpg", ".png"}) {
    const auto path = folder / ("photo" + extension);
    WriteFileAtomically(path, Picture(64, 36, extension));
    const cv::Mat before = ReadPhoto(path.string());
    const PhotoMetadata written = FullMetadata();
    WritePhotoMetadata(written, path);
    const PhotoMetadata read = ReadPhotoMetadata(path);
    EXPECT_EQ(read.width, 64);
    EXPECT_EQ(read.height, 36);
    ASSERT_TRUE(read.gps && read.focal_px && read.yaw_rad && read.pitch_rad) << extension;
    EXPECT_LT(EnuFromGeo(*written.gps, *read.gps).norm(), 1e-4);
    EXPECT_NEAR(*read.focal_px, *written.focal_px, 1e-5);
    EXPECT_NEAR(*read.yaw_rad, *written.yaw_rad, 1e-8);
    EXPECT_NEAR(*read.pitch_rad, *written.pitch_rad, 1e-8);
    EXPECT_EQ(read.camera_make, written.camera_make);
    EXPECT_EQ(read.camera_model, written.camera_model);
    EXPECT_EQ(read.capture_time, written.capture_time);
    EXPECT_EQ(cv::norm(before, ReadPhoto(path.string()), cv::NORM_INF), 0);  // pixels untouched
  }
}

TEST(PhotoMetadata, PositionsComeBackWithinATenthOfAMillimetreAllOverTheEarth) {
  const TestFolder folder;
  const std::string picture = Picture();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<GeoPosition> positions = {{0, -179.99999999999997, 0},
                                        {90, 180, 8848},
                                        {-90, 0, -400},
                                        {59.0 / 60, 1e-9, 0.00004},
                                        // Rounds up through seconds, minutes and degrees.
                                        {46.9999999999999, 7.98333333333333, -0.00006}};
  for (int i = 0; i < 100; ++i) {
    positions.push_back({89 * uniform(random), 180 * uniform(random), 5000 * uniform(random)});
  }
  for (const GeoPosition& position : positions) {
    PhotoMetadata metadata;
    metadata.gps = position;
    WriteFileAtomically(folder / "a.jpg", WithPhotoMetadata(picture, metadata));
    const PhotoMetadata read = ReadPhotoMetadata(folder / "a.jpg");
    ASSERT_TRUE(read.gps.has_value()) << position.lat_deg << " " << position.lon_deg;
    EXPECT_LT(EnuFromGeo(position, *read.gps).norm(), 1e-4);
    EXPECT_FALSE(read.focal_px || read.yaw_rad || read.pitch_rad);
  }
}

TEST(PhotoMetadata, OtherTagsAreKept) {
  const TestFolder folder;
  WriteWithTags(
      folder / "a.jpg", 64, 36,
      {{"Exif.Image.Model", "FC7303"}, {"Exif.Photo.DateTimeOriginal", "2021:08:20 07:34:45"}});
  PhotoMetadata metadata;
  metadata.gps = GeoPosition{1, 2, 3};
  WritePhotoMetadata(metadata, folder / "a.jpg");
  const PhotoMetadata read = ReadPhotoMetadata(folder / "a.jpg");
  EXPECT_EQ(read.camera_model, "FC7303");
  EXPECT_EQ(read.capture_time, "2021-08-20T07:34:45");
  EXPECT_TRUE(read.gps.has_value());
}

TEST(PhotoMetadata, APhotoWithoutExifHasASizeOnly) {
  const TestFolder folder;
  WriteFileAtomically(folder / "a.jpg", Picture(100, 50));
  const PhotoMetadata read = ReadPhotoMetadata(folder / "a.jpg");
  EXPECT_EQ(read.width, 100);
  EXPECT_EQ(read.height, 50);
  EXPECT_FALSE(read.gps || read.focal_px || read.yaw_rad || read.pitch_rad);
  EXPECT_TRUE(read.camera_make.empty() && read.camera_model.empty() && read.capture_time.empty());
}

TEST(PhotoMetadata, GpsOfACameraIsRead) {
  const TestFolder folder;
  WriteWithTags(folder / "a.jpg", 64, 36, GpsTags());
  const auto gps = ReadPhotoMetadata(folder / "a.jpg").gps;
  ASSERT_TRUE(gps.has_value());
  EXPECT_NEAR(gps->lat_deg, -33.51, 1e-12);
  EXPECT_NEAR(gps->lon_deg, -116.25, 1e-12);
  EXPECT_NEAR(gps->height_m, 123.45, 1e-12);
}

TEST(PhotoMetadata, AGpsTagThatCannotBeTrustedIsNoPosition) {
  const TestFolder folder;
  const auto expect_none = [&](const std::string& key, const std::string& text) {
    auto tags = GpsTags();
    tags.emplace_back(key, text);
    WriteWithTags(folder / "a.jpg", 64, 36, tags);
    EXPECT_FALSE(ReadPhotoMetadata(folder / "a.jpg").gps.has_value()) << key << " " << text;
  };
  expect_none("Exif.GPSInfo.GPSLatitude", "33/0 0/1 0/1");
  expect_none("Exif.GPSInfo.GPSLatitude", "133/1 0/1 0/1");
  expect_none("Exif.GPSInfo.GPSAltitude", "0/0");
  expect_none("Exif.GPSInfo.GPSStatus", "V");
  WriteWithTags(folder / "a.jpg", 64, 36,
                {{"Exif.GPSInfo.GPSLatitude", "0/1 0/1 0/1"},
                 {"Exif.GPSInfo.GPSLongitude", "0/1 0/1 0/1"},
                 {"Exif.GPSInfo.GPSAltitude", "10/1"}});
  EXPECT_FALSE(ReadPhotoMetadata(folder / "a.jpg").gps.has_value());  // no fix yet
}

TEST(PhotoMetadata, TheFocalLengthComesFromAKnownSensorOrThe35MmEquivalent) {
  const TestFolder folder;
  // The tags are those of the original, the picture was made smaller.
  const std::vector<std::pair<std::string, std::string>> stale = {
      {"Exif.Photo.PixelXDimension", "4000"},
      {"Exif.Photo.FocalPlaneXResolution", "4000/1"},
      {"Exif.Photo.FocalPlaneResolutionUnit", "3"},
      {"Exif.Photo.FocalLength", "449/100"}};
  WriteWithTags(folder / "stale.jpg", 160, 90, stale);
  EXPECT_FALSE(ReadPhotoMetadata(folder / "stale.jpg").focal_px.has_value());
  auto tags = stale;
  tags.emplace_back("Exif.Photo.FocalLengthIn35mmFilm", "24");
  WriteWithTags(folder / "equivalent.jpg", 160, 90, tags);
  EXPECT_NEAR(*ReadPhotoMetadata(folder / "equivalent.jpg").focal_px, 24.0 / 36 * 160, 1e-9);
  tags.emplace_back("Exif.Image.Model", "FC7303");
  WriteWithTags(folder / "dji.jpg", 90, 160, tags);  // portrait: the longer side counts
  EXPECT_NEAR(*ReadPhotoMetadata(folder / "dji.jpg").focal_px, 4.49 / 6.16 * 160, 1e-9);
  EXPECT_FALSE(SensorWidthMm("no such camera").has_value());
}

TEST(PhotoMetadata, AnUnknownCameraKeepsTheFocalLengthToTheMillimetre) {
  const TestFolder folder;
  PhotoMetadata metadata;
  metadata.focal_px = 50;
  metadata.camera_model = "no such camera";
  WriteFileAtomically(folder / "a.jpg", WithPhotoMetadata(Picture(), metadata));
  EXPECT_NEAR(*ReadPhotoMetadata(folder / "a.jpg").focal_px, 50, 64 / 36.0 / 2);
}

TEST(PhotoMetadata, GimbalAnglesAreReadUnlessAllAreZero) {
  const TestFolder folder;
  WriteWithTags(folder / "good.jpg", 64, 36, {}, GimbalXmp("+162.10", "-30.00"));
  const PhotoMetadata good = ReadPhotoMetadata(folder / "good.jpg");
  ASSERT_TRUE(good.yaw_rad && good.pitch_rad);
  EXPECT_NEAR(*good.yaw_rad, DegToRad(162.1), 1e-12);
  EXPECT_NEAR(*good.pitch_rad, DegToRad(-30), 1e-12);
  EXPECT_EQ(good.roll_rad, 0.0);
  WriteWithTags(folder / "zero.jpg", 64, 36, {}, GimbalXmp("+0.00", "+0.00"));
  const PhotoMetadata zero = ReadPhotoMetadata(folder / "zero.jpg");
  EXPECT_FALSE(zero.yaw_rad || zero.pitch_rad);
  WriteWithTags(folder / "north.jpg", 64, 36, {}, GimbalXmp("+0.00", "-90.00"));
  EXPECT_EQ(ReadPhotoMetadata(folder / "north.jpg").yaw_rad, 0.0);
}

TEST(PhotoMetadata, AccuracyOfThePosition) {
  const TestFolder folder;
  const auto gps = GpsTags();
  WriteWithTags(folder / "none.jpg", 64, 36, gps, "");
  EXPECT_FALSE(ReadPhotoMetadata(folder / "none.jpg").gps_sigma_horizontal_m);
  auto phone = gps;
  phone.emplace_back("Exif.GPSInfo.GPSHPositioningError", "9/2");
  WriteWithTags(folder / "phone.jpg", 64, 36, phone, "");
  const PhotoMetadata metadata = ReadPhotoMetadata(folder / "phone.jpg");
  EXPECT_EQ(metadata.gps_sigma_horizontal_m, 4.5);
  EXPECT_EQ(metadata.gps_sigma_vertical_m, 9.0);
  std::string xmp = GimbalXmp("+10.00", "-20.00");
  xmp.insert(xmp.find("drone-dji:Gimbal"),
             "drone-dji:RtkStdLon=\"0.012\" drone-dji:RtkStdLat=\"0.015\" "
             "drone-dji:RtkStdHgt=\"0.03\" drone-dji:RelativeAltitude=\"+134.20\" ");
  WriteWithTags(folder / "rtk.jpg", 64, 36, phone, xmp);
  const PhotoMetadata rtk = ReadPhotoMetadata(folder / "rtk.jpg");
  EXPECT_EQ(rtk.gps_sigma_horizontal_m, 0.015);
  EXPECT_EQ(rtk.gps_sigma_vertical_m, 0.03);
  EXPECT_EQ(rtk.relative_height_m, 134.2);
  EXPECT_FALSE(metadata.relative_height_m);
}

TEST(PhotoMetadata, AMagneticHeadingIsNotTaken) {
  const TestFolder folder;
  WriteWithTags(
      folder / "a.jpg", 64, 36,
      {{"Exif.GPSInfo.GPSImgDirectionRef", "M"}, {"Exif.GPSInfo.GPSImgDirection", "90/1"}});
  EXPECT_FALSE(ReadPhotoMetadata(folder / "a.jpg").yaw_rad.has_value());
}

TEST(PhotoMetadata, BadFilesAreNamed) {
  const TestFolder folder;
  ExpectError([&] { ReadPhotoMetadata(folder / "none.jpg"); }, {"none.jpg", "no such file"});
  WriteFileAtomically(folder / "text.jpg", "no picture at all");
  ExpectError([&] { ReadPhotoMetadata(folder / "text.jpg"); }, {"text.jpg"});
  ExpectError([&] { WritePhotoMetadata(FullMetadata(), folder / "text.jpg"); }, {"text.jpg"});
  EXPECT_EQ(ReadFile(folder / "text.jpg"), "no picture at all");
  WriteFileAtomically(folder / "cut.jpg", Picture().substr(0, 30));
  ExpectError([&] { ReadPhotoMetadata(folder / "cut.jpg"); }, {"cut.jpg"});
}

TEST(PhotoMetadata, BadValuesAreNotWritten) {
  const std::string picture = Picture();
  const auto expect = [&](auto change, const std::string& word) {
    PhotoMetadata metadata = FullMetadata();
    change(&metadata);
    ExpectError([&] { WithPhotoMetadata(picture, metadata); }, {word});
  };
  expect([](PhotoMetadata* m) { m->gps->lat_deg = 91; }, "GPS");
  expect([](PhotoMetadata* m) { m->gps->height_m = 1e9; }, "altitude");
  expect([](PhotoMetadata* m) { m->focal_px = -1; }, "focal");
  expect([](PhotoMetadata* m) { m->pitch_rad = 2; }, "pitch");
  expect([](PhotoMetadata* m) { m->yaw_rad = std::nan(""); }, "heading");
  expect([](PhotoMetadata* m) { m->capture_time = "yesterday"; }, "yesterday");
}

// With XMP packets, whose parser is not safe from threads by itself.
TEST(FolderMetadata, ReadsEveryPhotoAndNamesTheFirstBadOne) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "even");
  for (int i = 0; i < 40; ++i) {
    PhotoMetadata metadata;
    metadata.gps = GeoPosition{.lat_deg = 1, .lon_deg = 2, .height_m = static_cast<double>(i)};
    const auto path = folder / ((i % 2 == 0 ? "even/" : "") + std::to_string(100 + i) + ".jpg");
    WriteWithTags(path, 64, 36, {}, GimbalXmp("+10.00", "-" + std::to_string(i)));
    WritePhotoMetadata(metadata, path);
  }
  const auto all = ReadFolderMetadata(folder.path());
  ASSERT_EQ(all.size(), 40U);
  EXPECT_NEAR(all.at("even/104.jpg").gps->height_m, 4, 1e-4);
  EXPECT_NEAR(all.at("139.jpg").gps->height_m, 39, 1e-4);
  EXPECT_NEAR(*all.at("139.jpg").pitch_rad, DegToRad(-39), 1e-12);
  WriteFileAtomically(folder / "103.jpg", "x");
  WriteFileAtomically(folder / "even/200.jpg", "x");
  ExpectError([&] { ReadFolderMetadata(folder.path()); }, {"103.jpg"});
  ExpectError([&] { ReadFolderMetadata(folder / "nothing"); }, {"nothing"});
}

}  // namespace
}  // namespace colmap_ext
