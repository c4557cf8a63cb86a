// Depth and normal maps that we write, through the real `colmap stereo_fusion`.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"

namespace colmap_ext {
namespace {

constexpr int kMapWidth = 64;
constexpr int kMapHeight = 48;
constexpr double kDepth = 5;  // of a plane that faces all cameras

// Four cameras side by side that look along z at the plane z = kDepth, and points on it.
Reconstruction MakePlaneModel() {
  Reconstruction model;
  model.cameras[1] = {CameraModel::kPinhole, kMapWidth, kMapHeight, {60, 60, 32, 24}};
  const PinholeCamera camera = ToPinhole(model.cameras[1]);
  for (ImageId id = 1; id <= 4; ++id) {
    SparseImage& image = model.images[id];
    image.name = "view" + std::to_string(id) + ".png";
    image.camera_id = 1;
    image.cam_from_world.translation = {-0.4 * id + 1, 0, 0};
  }
  for (Point3DId id = 1; id <= 60; ++id) {
    SparsePoint& point = model.points[id];
    point.position = {0.1 * static_cast<double>(id % 10) - 0.5, 0.1 * static_cast<double>(id / 10),
                      kDepth};
    for (auto& [image_id, image] : model.images) {
      point.track.push_back({image_id, static_cast<std::uint32_t>(image.keypoints.size())});
      image.keypoints.push_back({camera.Project(image.cam_from_world * point.position), id});
    }
  }
  return model;
}

TEST(DenseMapWithColmap, StereoFusionFusesTheMapsThatWeWrite) {
  if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  TestFolder folder;
  const Reconstruction model = MakePlaneModel();
  WriteReconstructionBinary(model, folder / "sparse");
  std::filesystem::create_directories(folder / "images");
  std::string names;
  DenseMap depth(kMapWidth, kMapHeight, 1);
  DenseMap normal(kMapWidth, kMapHeight, 3);
  for (float& value : depth.data) value = static_cast<float>(kDepth);
  for (int row = 0; row < kMapHeight; ++row) {
    for (int col = 0; col < kMapWidth; ++col) normal.At(row, col, 2) = -1;
  }
  for (const auto& [id, image] : model.images) {
    const cv::Mat picture(kMapHeight, kMapWidth, CV_8UC3, cv::Scalar(10, 20, 30));
    ASSERT_TRUE(cv::imwrite((folder / ("images/" + image.name)).string(), picture));
    WriteDenseMap(depth, folder / ("stereo/depth_maps/" + image.name + ".geometric.bin"));
    WriteDenseMap(normal, folder / ("stereo/normal_maps/" + image.name + ".geometric.bin"));
    names += image.name + "\n";
  }
  WriteFileAtomically(folder / "stereo/fusion.cfg", names);
  WriteFileAtomically(folder / "stereo/patch-match.cfg", names);
  RunColmap({"stereo_fusion", "--workspace_path", folder.path().string(), "--output_path",
             (folder / "fused.ply").string(), "--StereoFusion.min_num_pixels", "3"});
  // x y z nx ny nz (float) and r g b follow the header.
  const std::string ply = ReadFile(folder / "fused.ply");
  const std::string end_header = "end_header\n";
  const std::size_t start = ply.find(end_header) + end_header.size();
  const std::size_t num_points = (ply.size() - start) / 27;
  ASSERT_GT(num_points, 500u);
  for (std::size_t i = 0; i < num_points; ++i) {
    float values[6];
    std::memcpy(values, ply.data() + start + 27 * i, sizeof(values));
    EXPECT_NEAR(values[2], kDepth, 1e-4);
    EXPECT_NEAR(values[5], -1, 1e-4);
  }
}

}  // namespace
}  // namespace colmap_ext
