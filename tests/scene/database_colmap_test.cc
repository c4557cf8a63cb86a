// Our database and the real `colmap`: each reads what the other wrote.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "scene/colmap_tool.h"
#include "sqlite_rows.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Access = Database::Access;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Blobs of all sizes, the same picture shifted by `shift_px`: SIFT finds and matches them.
void WritePicture(const fs::path& path, int shift_px) {
  std::mt19937 random(11);
  cv::Mat picture(kHeight, kWidth, CV_8UC3, cv::Scalar(90, 100, 110));
  for (int i = 0; i < 300; ++i) {
    const int x = static_cast<int>(random() % (kWidth + 60)) - 30;
    const int y = static_cast<int>(random() % kHeight);
    const int radius = 2 + static_cast<int>(random() % 9);
    const int gray = static_cast<int>(random() % 256);
    const cv::Scalar color(gray, 255 - gray, gray);
    cv::circle(picture, {x + shift_px, y}, radius, color, cv::FILLED, cv::LINE_AA);
  }
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(cv::imwrite(path.string(), picture));
}

void ExtractFeatures(const TestFolder& folder) {
  RunColmap({"feature_extractor", "--database_path", (folder / "d.db").string(), "--image_path",
             (folder / "images").string(), "--ImageReader.existing_camera_id", "7",
             "--SiftExtraction.use_gpu", "0", "--SiftExtraction.num_threads", "2"});
}

class DatabaseWithColmap : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  }

  // Our database with camera 7 and photos 31 and 12; a third photo is only in the folder.
  void MakeInput() {
    WritePicture(folder_ / "images/a.png", 0);
    WritePicture(folder_ / "images/b.png", 12);
    WritePicture(folder_ / "images/c.png", 20);
    Database database = Database::Create(folder_ / "d.db");
    Database::Transaction edit(database);
    edit.InsertCamera(7, {{CameraModel::kSimpleRadial, kWidth, kHeight, {300, 160, 120, 0}}, true});
    edit.InsertImage(31, {"a.png", 7, PositionPrior{{47.5, 8.25, 431}, PriorFrame::kUnknown}});
    edit.InsertImage(12, {"c.png", 7, std::nullopt});
    edit.Commit();
  }

  TestFolder folder_;
};

TEST_F(DatabaseWithColmap, OurSchemaIsColmaps) {
  RunColmap({"database_creator", "--database_path", (folder_ / "theirs.db").string()});
  Database::Create(folder_ / "ours.db");
  if (Query(folder_ / "theirs.db", "PRAGMA user_version") != std::vector<std::string>{"3800"}) {
    GTEST_SKIP() << "colmap is not 3.8";
  }
  for (const std::string sql :
       {"PRAGMA user_version", "SELECT type, name, tbl_name FROM sqlite_master ORDER BY name",
        "SELECT m.name, t.* FROM sqlite_master m, pragma_table_info(m.name) t "
        "WHERE m.type = 'table' ORDER BY m.name, t.cid",
        "SELECT m.name, f.* FROM sqlite_master m, pragma_foreign_key_list(m.name) f "
        "ORDER BY m.name",
        "SELECT m.name, i.name, i.\"unique\" FROM sqlite_master m, pragma_index_list(m.name) i "
        "ORDER BY m.name, i.name"}) {
    EXPECT_EQ(Query(folder_ / "ours.db", sql), Query(folder_ / "theirs.db", sql)) << sql;
  }
}

TEST_F(DatabaseWithColmap, ItsEmptyDatabaseIsReadAndEdited) {
  RunColmap({"database_creator", "--database_path", (folder_ / "d.db").string()});
  Database database = Database::Open(folder_ / "d.db", Access::kReadWrite);
  EXPECT_TRUE(database.ReadCameras().empty());
  EXPECT_TRUE(database.ReadImages().empty());
  if (database.user_version() != 3800) GTEST_SKIP() << "colmap is not 3.8";
  Database::Transaction edit(database);
  edit.InsertCamera(3, {{CameraModel::kPinhole, 10, 20, {1, 2, 3, 4}}, false});
  edit.Commit();
  EXPECT_EQ(database.ReadCameras().at(3).camera.height, 20);
}

TEST_F(DatabaseWithColmap, FeatureExtractorKeepsOurIdsCamerasAndPriors) {
  MakeInput();
  ExtractFeatures(folder_);
  const Database database = Database::Open(folder_ / "d.db", Access::kReadOnly);
  const auto images = database.ReadImages();
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images.at(31).name, "a.png");
  EXPECT_EQ(images.at(12).name, "c.png");
  EXPECT_EQ(images.at(32).name, "b.png");  // a new one: after the largest
  for (const auto& [id, image] : images) EXPECT_EQ(image.camera_id, 7u);
  ASSERT_TRUE(images.at(31).prior.has_value());
  EXPECT_EQ(images.at(31).prior->position, Eigen::Vector3d(47.5, 8.25, 431));
  EXPECT_FALSE(images.at(12).prior.has_value());
  EXPECT_FALSE(images.at(32).prior.has_value());
  const auto cameras = database.ReadCameras();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras.at(7).camera.params, (std::vector<double>{300, 160, 120, 0}));
}

TEST_F(DatabaseWithColmap, KeypointsAndDescriptorsOfFeatureExtractorAreRead) {
  MakeInput();
  ExtractFeatures(folder_);
  const Database database = Database::Open(folder_ / "d.db", Access::kReadOnly);
  const auto counts = database.NumKeypoints();
  ASSERT_EQ(counts.size(), 3u);
  for (const auto& [id, count] : counts) {
    EXPECT_GT(count, 50u);
    const KeypointMatrix keypoints = database.ReadKeypoints(id);
    const DescriptorMatrix descriptors = database.ReadDescriptors(id);
    ASSERT_EQ(static_cast<std::size_t>(keypoints.rows()), count);
    ASSERT_EQ(descriptors.rows(), keypoints.rows());
    EXPECT_EQ(descriptors.cols(), 128);
    EXPECT_GE(keypoints.col(0).minCoeff(), 0);
    EXPECT_LE(keypoints.col(0).maxCoeff(), kWidth);
    EXPECT_GE(keypoints.col(1).minCoeff(), 0);
    EXPECT_LE(keypoints.col(1).maxCoeff(), kHeight);
    // COLMAP scales SIFT to a length of 512.
    const double length = descriptors.row(0).cast<double>().norm();
    EXPECT_NEAR(length, 512, 10);
  }
}

TEST_F(DatabaseWithColmap, MatchesOfTheMatcherAreReadInBothOrders) {
  MakeInput();
  ExtractFeatures(folder_);
  RunColmap({"exhaustive_matcher", "--database_path", (folder_ / "d.db").string(),
             "--SiftMatching.use_gpu", "0"});
  const Database database = Database::Open(folder_ / "d.db", Access::kReadOnly);
  ASSERT_EQ(database.NumMatches().size(), 3u);
  const KeypointMatrix a = database.ReadKeypoints(31);
  const KeypointMatrix c = database.ReadKeypoints(12);
  const auto matches = database.ReadMatches({31, 12});
  ASSERT_GT(matches.size(), 20u);
  EXPECT_EQ(matches.size(), database.NumMatches().at({12, 31}));
  // c.png is a.png moved by 20 px to the right, so most matches are.
  std::size_t num_moved = 0;
  for (const auto& [in_a, in_c] : matches) {
    num_moved +=
        std::abs(c(in_c, 0) - a(in_a, 0) - 20) < 1 && std::abs(c(in_c, 1) - a(in_a, 1)) < 1;
  }
  EXPECT_GT(num_moved, matches.size() * 9 / 10);
  const auto geometry = database.ReadTwoViewGeometry({31, 12});
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->inlier_matches.size(), database.TwoViewSummaries().at({12, 31}).num_inliers);
  EXPECT_GT(geometry->inlier_matches.size(), 15u);
  // The homography proves that matrices are read row by row: it is that shift, and its inverse.
  EXPECT_LT((geometry->H.col(2).hnormalized() - Eigen::Vector2d(20, 0)).norm(), 0.2);
  const auto inverse = database.ReadTwoViewGeometry({12, 31});
  EXPECT_LT((inverse->H.col(2).hnormalized() - Eigen::Vector2d(-20, 0)).norm(), 0.2);
}

// ---- A scene of our own, through `colmap mapper`.

struct SyntheticView {
  ImageId id;
  Rigid3d cam_from_world;
};

Eigen::Vector2d ProjectInto(const SyntheticView& view, const Eigen::Vector3d& point) {
  const PinholeCamera camera{kWidth, kHeight, 300, 300, 160, 120};
  return camera.Project(view.cam_from_world * point);
}

TEST_F(DatabaseWithColmap, MapperReconstructsFromKeypointsAndMatchesThatWeWrote) {
  // Six views on an arc of 1 m radius steps, looking at a cloud 6 m away.
  std::vector<SyntheticView> views;
  for (int i = 0; i < 6; ++i) {
    const double angle = 0.12 * (i - 2.5);
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
    // The camera turns about the cloud's middle at (0, 0, 6).
    const Eigen::Vector3d middle(0, 0, 6);
    views.push_back({static_cast<ImageId>(100 - 7 * i), {rotation, middle - rotation * middle}});
  }
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 150; ++i) {
    points.emplace_back(1.5 * uniform(random), uniform(random), 6 + uniform(random));
  }
  {
    Database database = Database::Create(folder_ / "d.db");
    Database::Transaction edit(database);
    edit.InsertCamera(7, {{CameraModel::kSimplePinhole, kWidth, kHeight, {300, 160, 120}}, true});
    for (const SyntheticView& view : views) {
      edit.InsertImage(view.id, {"view" + std::to_string(view.id) + ".png", 7, std::nullopt});
      KeypointMatrix keypoints(static_cast<Eigen::Index>(points.size()), 2);
      for (std::size_t i = 0; i < points.size(); ++i) {
        keypoints.row(static_cast<Eigen::Index>(i)) =
            ProjectInto(view, points[i]).cast<float>().transpose();
      }
      edit.InsertKeypoints(view.id, keypoints);
    }
    TwoViewGeometry geometry;
    geometry.config = TwoViewConfig::kCalibrated;
    for (std::uint32_t i = 0; i < points.size(); ++i) geometry.inlier_matches.emplace_back(i, i);
    for (std::size_t i = 0; i < views.size(); ++i) {
      for (std::size_t j = i + 1; j < views.size(); ++j) {
        edit.InsertMatches({views[i].id, views[j].id}, geometry.inlier_matches);
        edit.InsertTwoViewGeometry({views[i].id, views[j].id}, geometry);
      }
    }
    edit.Commit();
  }
  fs::create_directories(folder_ / "images");
  fs::create_directories(folder_ / "sparse");
  RunColmap({"mapper", "--database_path", (folder_ / "d.db").string(), "--image_path",
             (folder_ / "images").string(), "--output_path", (folder_ / "sparse").string(),
             "--Mapper.extract_colors", "0", "--Mapper.ba_refine_focal_length", "0"});
  const Reconstruction model = ReadReconstruction(folder_ / "sparse/0");
  ASSERT_EQ(model.images.size(), views.size());
  EXPECT_EQ(model.points.size(), points.size());
  Eigen::Matrix3Xd estimated(3, views.size()), truth(3, views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const SparseImage& image = model.images.at(views[i].id);
    EXPECT_EQ(image.name, "view" + std::to_string(views[i].id) + ".png");
    estimated.col(static_cast<Eigen::Index>(i)) = CameraCenter(image.cam_from_world);
    truth.col(static_cast<Eigen::Index>(i)) = CameraCenter(views[i].cam_from_world);
  }
  const Sim3d truth_from_model = EstimateSimilarity(estimated, truth);
  for (Eigen::Index i = 0; i < truth.cols(); ++i) {
    EXPECT_LT((truth_from_model * estimated.col(i) - truth.col(i)).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace colmap_ext
