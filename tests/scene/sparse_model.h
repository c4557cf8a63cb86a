// A small sparse model with known numbers, for the tests of this module.
#pragma once

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// A camera of every model, `num_images` images (camera ids cycle) and `num_points` points, each
// seen by three images; further keypoints without a point. Ids have gaps, as in real models.
inline Reconstruction MakeSparseModel(int num_images = 11, int num_points = 40) {
  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Reconstruction model;
  for (int id = 0; id <= 10; ++id) {
    Camera camera;
    camera.model = static_cast<CameraModel>(id);
    camera.width = 640;
    camera.height = 368;
    const CameraModelInfo& info = GetCameraModelInfo(id);
    for (int i = 0; i < info.num_params; ++i) camera.params.push_back(0.01 * uniform(random));
    camera.params[0] = camera.params[1] = 500 + uniform(random);
    camera.params[2] = 184 + uniform(random);
    model.cameras[static_cast<CameraId>(2 * id + 1)] = camera;
  }
  std::vector<ImageId> image_ids;
  for (int i = 0; i < num_images; ++i) {
    SparseImage image;
    image.name = "flight" + std::to_string(i % 2) + "/DJI_" + std::to_string(1000 + i) + ".JPG";
    image.camera_id = static_cast<CameraId>(2 * (i % 11) + 1);
    image.cam_from_world.rotation =
        Eigen::Quaterniond(uniform(random), uniform(random), uniform(random), 2).normalized();
    image.cam_from_world.translation = {uniform(random), uniform(random), 1e-17 * uniform(random)};
    image_ids.push_back(static_cast<ImageId>(3 * i + 2));
    model.images[image_ids.back()] = image;
  }
  for (int i = 0; i < num_points; ++i) {
    const Point3DId id = static_cast<Point3DId>(5 * i + 7);
    SparsePoint point;
    point.position = {10 * uniform(random), 10 * uniform(random), uniform(random)};
    point.color = {static_cast<std::uint8_t>(i), 255, 0};
    point.error_px = std::abs(uniform(random));
    for (int k = 0; k < 3; ++k) {
      const ImageId image_id = image_ids[static_cast<std::size_t>((i + k) % num_images)];
      std::vector<Keypoint2D>& keypoints = model.images[image_id].keypoints;
      point.track.push_back({image_id, static_cast<std::uint32_t>(keypoints.size())});
      keypoints.push_back({{300 * uniform(random), 100 * uniform(random)}, id});
      keypoints.push_back({{300 * uniform(random), 100 * uniform(random)}, kInvalidPoint3DId});
    }
    model.points[id] = point;
  }
  return model;
}

}  // namespace colmap_ext
