#include "colmap_ext/scene/photo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

constexpr int kPhotoWidth = 96;
constexpr int kPhotoHeight = 64;

cv::Mat Gradient(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      picture.at<cv::Vec3b>(row, col) = {static_cast<std::uint8_t>(2 * col),
                                         static_cast<std::uint8_t>(3 * row), 77};
    }
  }
  return picture;
}

std::string Encoded(const cv::Mat& picture, const std::string& extension,
                    const std::vector<int>& parameters = {}) {
  std::vector<unsigned char> buffer;
  cv::imencode(extension, picture, buffer, parameters);
  return {buffer.begin(), buffer.end()};
}

TEST(ReadPhoto, DecodesLosslessPicturesExactly) {
  const TestFolder folder;
  const cv::Mat picture = Gradient(kPhotoWidth, kPhotoHeight);
  for (const std::string extension : {".png", ".tif"}) {
    WriteFileAtomically(folder / ("a" + extension), Encoded(picture, extension));
    const cv::Mat read = ReadPhoto((folder / ("a" + extension)).string());
    ASSERT_EQ(read.size(), picture.size());
    ASSERT_EQ(read.type(), CV_8UC3);
    EXPECT_EQ(cv::norm(read, picture, cv::NORM_INF), 0);
  }
}

TEST(ReadPhoto, GreyPicturesComeAsColour) {
  const TestFolder folder;
  WriteFileAtomically(folder / "grey.png", Encoded(cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)), ".png"));
  EXPECT_EQ(ReadPhoto((folder / "grey.png").string()).at<cv::Vec3b>(3, 3), cv::Vec3b(9, 9, 9));
}

// OpenCV would return a picture with a grey lower part for most of these.
TEST(ReadPhoto, EveryTruncationIsAnError) {
  const TestFolder folder;
  const cv::Mat picture = Gradient(24, 16);
  const std::vector<std::string> files = {
      Encoded(picture, ".jpg"),
      Encoded(picture, ".jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
      Encoded(picture, ".jpg", {cv::IMWRITE_JPEG_RST_INTERVAL, 1}),
      Encoded(picture, ".png"),
      Encoded(picture, ".tif"),
  };
  const std::string path = (folder / "cut").string();
  for (const std::string& bytes : files) {
    WriteFileAtomically(path, bytes);
    EXPECT_EQ(ReadPhoto(path).cols, 24);
    for (std::size_t size = 0; size < bytes.size(); size += size < 8 ? 1 : 7) {
      WriteFileAtomically(path, bytes.substr(0, size));
      ExpectError([&] { ReadPhoto(path); }, {path});
    }
    WriteFileAtomically(path, bytes.substr(0, bytes.size() - 1));
    ExpectError([&] { ReadPhoto(path); }, {path});
  }
}

// A card that ran full or a copy that broke leaves zeros where the rest of the file should be.
TEST(ReadPhoto, AZeroFilledTailIsAnError) {
  const TestFolder folder;
  std::string bytes = Encoded(Gradient(kPhotoWidth, kPhotoHeight), ".jpg");
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), bytes.end(), '\0');
  WriteFileAtomically(folder / "zeros.jpg", bytes);
  ExpectError([&] { ReadPhoto((folder / "zeros.jpg").string()); }, {"zeros.jpg", "truncated"});
}

TEST(ReadPhoto, WhatFollowsTheEndOfAJpegDoesNotMatter) {
  const TestFolder folder;
  WriteFileAtomically(folder / "a.jpg",
                      Encoded(Gradient(kPhotoWidth, kPhotoHeight), ".jpg") + "preview");
  EXPECT_EQ(ReadPhoto((folder / "a.jpg").string()).cols, kPhotoWidth);
}

TEST(ReadPhoto, WhatIsNoPictureIsAnError) {
  const TestFolder folder;
  ExpectError([&] { ReadPhoto((folder / "none.jpg").string()); }, {"none.jpg", "no such file"});
  WriteFileAtomically(folder / "page.jpg", "<html>not found</html>");
  ExpectError([&] { ReadPhoto((folder / "page.jpg").string()); },
              {"page.jpg", "no JPEG, PNG or TIFF"});
  WriteFileAtomically(folder / "bare.jpg", "\xFF\xD8\xFF\xD9");
  ExpectError([&] { ReadPhoto((folder / "bare.jpg").string()); }, {"bare.jpg", "no picture"});
}

// ---- LoadPhotoSet ----

Reconstruction ModelWith(const Camera& camera, const std::vector<std::string>& names) {
  Reconstruction model;
  model.cameras[5] = camera;
  ImageId id = 10;
  for (const std::string& name : names) {
    SparseImage image;
    image.name = name;
    image.camera_id = 5;
    image.cam_from_world.translation = {0, 0, static_cast<double>(id)};
    model.images[id--] = image;
  }
  return model;
}

Camera Pinhole() {
  return {.model = CameraModel::kPinhole,
          .width = kPhotoWidth,
          .height = kPhotoHeight,
          .params = {80, 82, 48.5, 31.5}};
}

TEST(LoadPhotoSet, PhotosAreSortedByNameAndKeepTheirPoses) {
  const TestFolder folder;
  const Reconstruction model = ModelWith(Pinhole(), {"b.png", "a/z.png", "c.png"});
  const cv::Mat picture = Gradient(kPhotoWidth, kPhotoHeight);
  for (const auto& [id, image] : model.images) {
    WriteFileAtomically(folder / image.name, Encoded(picture, ".png"));
  }
  const PhotoSet set = LoadPhotoSet(model, folder.path().string(), true);
  ASSERT_EQ(set.photos.size(), 3U);
  EXPECT_EQ(set.photos[0].name, "a/z.png");
  EXPECT_EQ(set.photos[1].name, "b.png");
  EXPECT_EQ(set.photos[2].name, "c.png");
  for (const PosedPhoto& photo : set.photos) {
    EXPECT_EQ(photo.cam_from_world.translation.z(), photo.image_id);
    EXPECT_EQ(photo.camera.fy, 82);
    EXPECT_EQ(cv::norm(photo.bgr, picture, cv::NORM_INF), 0);  // a pinhole photo is left alone
  }
}

TEST(LoadPhotoSet, WithoutPixelsNoFileIsOpened) {
  const PhotoSet set = LoadPhotoSet(ModelWith(Pinhole(), {"a.jpg"}), "/nowhere", false);
  ASSERT_EQ(set.photos.size(), 1U);
  EXPECT_TRUE(set.photos[0].bgr.empty());
}

TEST(LoadPhotoSet, SupportPointsNameTheirPhotosInOrderAndOnce) {
  Reconstruction model = ModelWith(Pinhole(), {"c.png", "b.png", "a.png"});  // ids 10, 9, 8
  for (auto& [id, image] : model.images) {
    image.cam_from_world = {};
    image.keypoints = {{{48.5, 31.5}, 1}, {{48.5 + 8 + 3, 31.5 + 4}, 1}};
  }
  SparsePoint known;
  known.position = {1, 2, 3};
  known.error_px = 0.25;
  known.track = {{10, 0}, {9, 0}, {10, 1}};
  model.points[1] = known;
  SparsePoint unknown;
  unknown.position = {1, 0, 10};  // projects to (48.5 + 8, 31.5)
  unknown.error_px = -1;
  unknown.track = {{9, 1}, {8, 1}};  // 3 and 4 px off: 5 px
  model.points[2] = unknown;
  const PhotoSet set = LoadPhotoSet(model, "", false);
  ASSERT_EQ(set.points.size(), 2U);
  EXPECT_EQ(set.points[0].position, known.position);
  EXPECT_EQ(set.points[0].error_px, 0.25);
  EXPECT_EQ(set.points[0].photo_indices, (std::vector<int>{1, 2}));
  EXPECT_EQ(set.points[1].photo_indices, (std::vector<int>{0, 1}));
  EXPECT_NEAR(set.points[1].error_px, 5, 1e-12);
}

// Smooth, 16 px a period: half a pixel of error would be about 20 grey levels.
double Brightness(const Eigen::Vector2d& normalized) {
  return 128 + 50 * std::sin(normalized.x() * 31.4) + 50 * std::cos(normalized.y() * 31.4);
}

void ExpectUndistorts(const Camera& camera) {
  const TestFolder folder;
  cv::Mat photo(camera.height, camera.width, CV_8UC3);
  for (int row = 0; row < photo.rows; ++row) {
    for (int col = 0; col < photo.cols; ++col) {
      const auto ray = NormalizedFromImage(camera, {col + 0.5, row + 0.5});
      ASSERT_TRUE(ray.has_value());
      const double value = std::round(Brightness(*ray));
      photo.at<cv::Vec3b>(row, col) = cv::Vec3b::all(static_cast<std::uint8_t>(value));
    }
  }
  WriteFileAtomically(folder / "a.png", Encoded(photo, ".png"));
  const PhotoSet set = LoadPhotoSet(ModelWith(camera, {"a.png"}), folder.path().string(), true);
  const PosedPhoto& result = set.photos.at(0);
  ASSERT_EQ(result.bgr.size(), photo.size());
  int compared = 0;
  double worst = 0;
  for (int row = 0; row < photo.rows; ++row) {
    for (int col = 0; col < photo.cols; ++col) {
      const Eigen::Vector2d ray = result.camera.Ray({col + 0.5, row + 0.5}).head<2>();
      const Eigen::Vector2d source = ImageFromNormalized(camera, ray);
      if ((source - Eigen::Vector2d(photo.cols, photo.rows) / 2)
              .cwiseAbs()
              .cwiseQuotient(Eigen::Vector2d(photo.cols / 2 - 2, photo.rows / 2 - 2))
              .maxCoeff() > 1) {
        continue;  // not in the photo
      }
      const double value = result.bgr.at<cv::Vec3b>(row, col)[0];
      worst = std::max(worst, std::abs(value - Brightness(ray)));
      ++compared;
    }
  }
  EXPECT_LT(worst, 6);
  EXPECT_GT(compared, photo.rows * photo.cols / 2);
}

TEST(LoadPhotoSet, DistortedPhotosBecomePinholePhotos) {
  ExpectUndistorts({.model = CameraModel::kSimpleRadial,
                    .width = kPhotoWidth,
                    .height = kPhotoHeight,
                    .params = {80, 48, 32, -0.15}});
  ExpectUndistorts({.model = CameraModel::kOpenCV,
                    .width = kPhotoWidth,
                    .height = kPhotoHeight,
                    .params = {80, 84, 47, 33, 0.1, 0.02, 0.004, -0.003}});
  ExpectUndistorts({.model = CameraModel::kOpenCVFisheye,
                    .width = kPhotoWidth,
                    .height = kPhotoHeight,
                    .params = {80, 80, 48, 32, 0.02, 0.01, 0, 0}});
}

TEST(LoadPhotoSet, TheFirstBadPhotoIsNamed) {
  const TestFolder folder;
  const Reconstruction model = ModelWith(Pinhole(), {"d.png", "c.png", "b.png", "a.png"});
  const std::string good = Encoded(Gradient(kPhotoWidth, kPhotoHeight), ".png");
  for (const auto& [id, image] : model.images) WriteFileAtomically(folder / image.name, good);
  WriteFileAtomically(folder / "b.png", good.substr(0, good.size() / 2));
  WriteFileAtomically(folder / "c.png", Encoded(Gradient(kPhotoWidth, kPhotoHeight + 1), ".png"));
  for (int i = 0; i < 20; ++i) {  // whichever thread is faster
    ExpectError([&] { LoadPhotoSet(model, folder.path().string(), true); }, {"b.png", "truncated"});
  }
  WriteFileAtomically(folder / "b.png", good);
  ExpectError([&] { LoadPhotoSet(model, folder.path().string(), true); },
              {"c.png", "96 x 65", "96 x 64"});
  std::filesystem::remove(folder / "a.png");
  ExpectError([&] { LoadPhotoSet(model, folder.path().string(), true); },
              {"a.png", "no such file"});
}

TEST(LoadPhotoSet, AMissingCameraOrImageIsNamed) {
  Reconstruction model = ModelWith(Pinhole(), {"a.png"});
  model.points[3].track = {{77, 0}};
  model.points[3].error_px = 1;
  ExpectError([&] { LoadPhotoSet(model, "", false); }, {"point 3", "image 77"});
  model.cameras.clear();
  ExpectError([&] { LoadPhotoSet(model, "", false); }, {"a.png", "camera 5"});
}

TEST(WritePhoto, ComesBackAndObeysTheQuality) {
  const TestFolder folder;
  const cv::Mat picture = Gradient(kPhotoWidth, kPhotoHeight);
  WritePhoto(picture, folder / "a.png");
  EXPECT_EQ(cv::norm(ReadPhoto((folder / "a.png").string()), picture, cv::NORM_INF), 0);
  WritePhoto(picture, folder / "good.jpg", 98);
  WritePhoto(picture, folder / "poor.jpg", 10);
  EXPECT_LT(cv::norm(ReadPhoto((folder / "good.jpg").string()), picture, cv::NORM_L1),
            cv::norm(ReadPhoto((folder / "poor.jpg").string()), picture, cv::NORM_L1));
}

TEST(WritePhoto, AnUnknownExtensionIsAnErrorThatNamesTheFile) {
  const TestFolder folder;
  try {
    WritePhoto(Gradient(8, 8), folder / "a.nonsense");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("a.nonsense"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.nonsense"));
}

// Photo k stands at x = k and looks along z; the points say who shares what.
PhotoSet PhotosInARow(int count, const std::vector<std::vector<int>>& seen_by) {
  PhotoSet photos;
  for (int k = 0; k < count; ++k) {
    PosedPhoto photo;
    photo.cam_from_world.translation = Eigen::Vector3d(-k, 0, 0);
    photos.photos.push_back(photo);
  }
  for (const std::vector<int>& seen : seen_by) {
    SupportPoint point;
    point.position = {0, 0, 10};
    point.photo_indices = seen;
    photos.points.push_back(point);
  }
  return photos;
}

TEST(RankPartners, MostSharedFirstTiesByIndexAndNoMoreThanAsked) {
  const PhotoSet photos = PhotosInARow(4, {{0, 1}, {0, 2}, {0, 2}, {0, 3}});
  const auto one = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return 1.0; };
  const auto partners = RankPartners(photos, one, 2);
  ASSERT_EQ(partners.size(), 4u);
  EXPECT_EQ(partners[0], (std::vector<int>{2, 1}));
  EXPECT_EQ(partners[3], (std::vector<int>{0}));
}

TEST(RankPartners, TheScoreGetsBothRaysAndNothingPositiveIsNoPartner) {
  const PhotoSet photos = PhotosInARow(3, {{0, 1, 2}});
  const auto baseline = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    EXPECT_DOUBLE_EQ(a.z(), 10);
    return (a - b).norm() > 1.5 ? 1.0 : 0.0;
  };
  const auto partners = RankPartners(photos, baseline, 5);
  EXPECT_EQ(partners[0], (std::vector<int>{2}));
  EXPECT_TRUE(partners[1].empty());
}

}  // namespace
}  // namespace colmap_ext
