#include "sfm/photo_catalog.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

std::string Jpeg(const PhotoMetadata& metadata) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", cv::Mat(36, 64, CV_8UC3, cv::Scalar(90, 120, 60)), bytes);
  return WithPhotoMetadata({bytes.begin(), bytes.end()}, metadata);
}

// Three photos with GPS 10 m apart in height: a.jpg at 100 m, b.jpg at 110 m, c.jpg at 120 m.
class PhotoCatalogTest : public testing::Test {
 protected:
  PhotoCatalogTest() {
    for (int i = 0; i < 3; ++i) {
      PhotoMetadata metadata;
      metadata.gps = GeoPosition{.lat_deg = 47, .lon_deg = 8, .height_m = 100.0 + 10 * i};
      metadata.yaw_rad = 0.5;
      metadata.pitch_rad = -0.3;
      WriteFileAtomically(folder_ / (std::string(1, static_cast<char>('a' + i)) + ".jpg"),
                          Jpeg(metadata));
    }
    input_.image_path = folder_.path();
    input_.database_path = folder_ / "database.db";
  }

  PhotoCatalog Read() const { return ReadCatalog(input_, JobControl()); }

  TestFolder folder_;
  SparseUpdateInput input_;
};

TEST_F(PhotoCatalogTest, ExifAroundTheFirstPhoto) {
  const PhotoCatalog catalog = Read();
  ASSERT_EQ(catalog.photos.size(), 3u);
  EXPECT_EQ(catalog.num_positions, 3);
  ASSERT_TRUE(catalog.origin);
  EXPECT_NEAR(catalog.origin->height_m, 100, 1e-3);
  EXPECT_LT((*catalog.photos[2].position_in_world - Eigen::Vector3d(0, 0, 20)).norm(), 1e-3);
  EXPECT_FALSE(catalog.photos[0].sigma_horizontal_m);
  // Heading and pitch alone do not tell the roll.
  EXPECT_FALSE(catalog.photos[0].up_in_cam);
}

TEST_F(PhotoCatalogTest, TheOriginOfTheModelIsKept) {
  input_.frame.origin = GeoPosition{.lat_deg = 47, .lon_deg = 8, .height_m = 90};
  EXPECT_NEAR(Read().photos[0].position_in_world->z(), 10, 1e-3);
}

TEST_F(PhotoCatalogTest, JournalBeforeExifAndGivenBeforeJournal) {
  CaptureRecord record;
  record.index = 1;
  record.position = {.lat_deg = 47, .lon_deg = 8, .height_m = 200};
  record.sigma_horizontal_m = 0.02;
  record.sigma_vertical_m = 0.04;
  record.cam_from_enu = CamFromWorld({0, 0, 0}, {1.0, -0.2}).rotation;
  WriteFileAtomically(folder_ / "captures.jsonl",
                      CaptureJournalLine("b.jpg", record) + CaptureJournalLine("c.jpg", record));
  input_.geo_position_of_photo["c.jpg"] = {.lat_deg = 47, .lon_deg = 8, .height_m = 300};
  const PhotoCatalog catalog = Read();
  EXPECT_NEAR(catalog.photos[0].geo->height_m, 100, 1e-3);
  EXPECT_NEAR(catalog.photos[1].geo->height_m, 200, 1e-9);
  EXPECT_NEAR(catalog.photos[2].geo->height_m, 300, 1e-9);
  EXPECT_EQ(catalog.photos[1].sigma_vertical_m, 0.04);
  EXPECT_FALSE(catalog.photos[2].sigma_vertical_m) << "of another source";
  ASSERT_TRUE(catalog.photos[1].up_in_cam);
  EXPECT_NEAR(*catalog.photos[1].metadata.yaw_rad, 1.0, 1e-9);
  // Up in a camera that looks down by 0.2 rad.
  const Eigen::Vector3d up(0, -std::cos(0.2), -std::sin(0.2));
  EXPECT_LT((*catalog.photos[1].up_in_cam - up).norm(), 1e-9);
}

TEST_F(PhotoCatalogTest, LocalPositionsNeedNoEarth) {
  input_.local_position_of_photo = {{"a.jpg", {1, 2, 3}}, {"c.jpg", {4, 5, 6}}};
  const PhotoCatalog catalog = Read();
  EXPECT_FALSE(catalog.origin);
  EXPECT_EQ(catalog.num_positions, 2);
  EXPECT_EQ(*catalog.photos[2].position_in_world, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(catalog.photos[1].position_in_world);
}

TEST_F(PhotoCatalogTest, SaysWhatIsWrong) {
  input_.geo_position_of_photo["x.jpg"] = {.lat_deg = 47, .lon_deg = 8, .height_m = 0};
  ExpectError([&] { Read(); }, {"x.jpg", "none of the photos"});
  input_.geo_position_of_photo = {{"a.jpg", {.lat_deg = 147, .lon_deg = 8, .height_m = 0}}};
  ExpectError([&] { Read(); }, {"a.jpg", "147"});
  input_.geo_position_of_photo.clear();
  std::filesystem::remove(folder_ / "a.jpg");
  ExpectError([&] { Read(); }, {"only 2 photos"});
}

}  // namespace
}  // namespace colmap_ext
