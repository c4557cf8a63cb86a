#include "session/take_off_height.h"

#include <gtest/gtest.h>

#include <exiv2/exiv2.hpp>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/geom/transforms.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

PosedPhoto PhotoAt(const TestFolder& folder, const std::string& name, double z_m,
                   const std::string& relative_altitude) {
  const std::string path = (folder / name).string();
  cv::imwrite(path, cv::Mat(16, 16, CV_8UC3, cv::Scalar::all(90)));
  if (!relative_altitude.empty()) {
    const auto image = Exiv2::ImageFactory::open(path);
    image->setXmpPacket(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
        "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description "
        "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\" drone-dji:RelativeAltitude=\"" +
        relative_altitude + "\"/></rdf:RDF></x:xmpmeta>");
    image->writeXmpFromPacket(true);
    image->writeMetadata();
  }
  PosedPhoto photo;
  photo.name = name;
  photo.cam_from_world = CamFromWorld({3, 4, z_m}, {0.0, 0.0});
  return photo;
}

TEST(TakeOffBelowOrigin, IsTheMedianOfThePhotosThatSayIt) {
  const TestFolder folder;
  PhotoSet photos;
  photos.photos = {PhotoAt(folder, "a.jpg", 0, "+134.20"), PhotoAt(folder, "b.jpg", 10, "+144.00"),
                   PhotoAt(folder, "c.jpg", 5, ""), PhotoAt(folder, "d.jpg", -2, "+500.00")};
  const auto below_m = TakeOffBelowOrigin(photos, folder.path());
  ASSERT_TRUE(below_m);
  EXPECT_NEAR(*below_m, 134.2, 1e-9);
}

TEST(TakeOffBelowOrigin, IsUnknownWhenNoneSaysIt) {
  const TestFolder folder;
  PhotoSet photos;
  photos.photos = {PhotoAt(folder, "a.jpg", 0, ""), PhotoAt(folder, "b.jpg", 10, "")};
  EXPECT_FALSE(TakeOffBelowOrigin(photos, folder.path()));
}

}  // namespace
}  // namespace colmap_ext
