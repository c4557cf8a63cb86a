// Models with exact truth for tests of the bundle adjustment and of georegistration.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

struct SyntheticModel {
  Camera camera = {CameraModel::kPinhole, 640, 368, {480, 480, 320, 184}};
  double keypoint_noise_px = 0;
  unsigned seed = 1;
};

inline Eigen::Vector3d Gaussian3(std::mt19937_64* random, double sigma) {
  std::normal_distribution<double> normal(0, sigma);
  const double x = normal(*random), y = normal(*random), z = normal(*random);
  return {x, y, z};
}

// Adds an observation of every point inside the image of every camera, then drops points that fewer
// than two photos see.
inline void Observe(const SyntheticModel& how, const std::vector<Rigid3d>& poses,
                    const std::vector<Eigen::Vector3d>& points, Reconstruction* model) {
  std::mt19937_64 random(how.seed);
  std::normal_distribution<double> noise(0, how.keypoint_noise_px);
  model->cameras[1] = how.camera;
  for (std::size_t p = 0; p < points.size(); ++p) model->points[p + 1].position = points[p];
  for (const Rigid3d& pose : poses) {
    const auto id = static_cast<ImageId>(model->images.size() + 1);
    SparseImage& image = model->images[id];
    image.name = "photo" + std::to_string(1000 + id) + ".jpg";
    image.camera_id = 1;
    image.cam_from_world = pose;
    for (auto& [point_id, point] : model->points) {
      const Eigen::Vector3d in_cam = pose * point.position;
      if (in_cam.z() < 0.5) continue;
      Eigen::Vector2d pixel = ImageFromNormalized(how.camera, in_cam.hnormalized());
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 640 || pixel.y() > 368) continue;
      pixel += how.keypoint_noise_px > 0 ? Eigen::Vector2d(noise(random), noise(random))
                                         : Eigen::Vector2d::Zero();
      point.track.push_back({id, static_cast<std::uint32_t>(image.keypoints.size())});
      image.keypoints.push_back({pixel, point_id});
    }
  }
  std::erase_if(model->points, [&](const auto& entry) {
    if (entry.second.track.size() >= 2) return false;
    for (const TrackElement& element : entry.second.track) {
      model->images[element.image_id].keypoints[element.keypoint_index].point3D_id =
          kInvalidPoint3DId;
    }
    return true;
  });
}

// Photos on a circle of 20 m around a cloud of points, at changing heights, looking at its middle.
inline Reconstruction RingModel(int num_photos, int num_points, const SyntheticModel& how = {}) {
  std::mt19937_64 random(how.seed + 100);
  std::vector<Rigid3d> poses;
  for (int k = 0; k < num_photos; ++k) {
    const double angle = 2 * std::numbers::pi * k / num_photos;
    const Eigen::Vector3d center(20 * std::cos(angle), 20 * std::sin(angle), 8 + 3 * (k % 3));
    const double pitch = -std::atan2(center.z() - 4, 20);
    poses.push_back(CamFromWorld(center, {std::atan2(-center.x(), -center.y()), pitch}));
  }
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < num_points; ++k) {
    points.push_back(Eigen::Vector3d(0, 0, 4) + Gaussian3(&random, 3));
  }
  Reconstruction model;
  Observe(how, poses, points, &model);
  return model;
}

// Photos in a row 3 m apart, 20 m above rough ground, so that errors can add up along it.
inline Reconstruction ChainModel(int num_photos, int num_points, const SyntheticModel& how = {}) {
  std::mt19937_64 random(how.seed + 200);
  std::uniform_real_distribution<double> along(-10, 3 * num_photos + 10), across(-8, 8);
  std::vector<Rigid3d> poses;
  for (int k = 0; k < num_photos; ++k) {
    poses.push_back(CamFromWorld({3.0 * k, 0, 20}, {0, -1.2}));
  }
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < num_points; ++k) {
    const double x = along(random), y = 8 + across(random);
    points.push_back({x, y, 2 * std::sin(x) + Gaussian3(&random, 0.5).z()});
  }
  Reconstruction model;
  Observe(how, poses, points, &model);
  return model;
}

inline void PerturbPoses(double sigma_m, double sigma_rad, unsigned seed, Reconstruction* model) {
  std::mt19937_64 random(seed);
  for (auto& [id, image] : model->images) {
    const Eigen::Vector3d center = CameraCenter(image.cam_from_world) + Gaussian3(&random, sigma_m);
    const Eigen::Vector3d turn = Gaussian3(&random, sigma_rad);
    Rigid3d& pose = image.cam_from_world;
    pose.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * pose.rotation;
    pose.translation = -(pose.rotation * center);
  }
}

inline void PerturbPoints(double sigma_m, unsigned seed, Reconstruction* model) {
  std::mt19937_64 random(seed);
  for (auto& [id, point] : model->points) point.position += Gaussian3(&random, sigma_m);
}

// Least-squares similarity from the camera centres of `model` to those of `truth`.
inline Sim3d TruthFromModel(const Reconstruction& truth, const Reconstruction& model) {
  Eigen::Matrix3Xd from(3, model.images.size()), to(3, model.images.size());
  Eigen::Index column = 0;
  for (const auto& [id, image] : model.images) {
    from.col(column) = CameraCenter(image.cam_from_world);
    to.col(column++) = CameraCenter(truth.images.at(id).cam_from_world);
  }
  return EstimateSimilarity(from, to);
}

// Largest distance of a camera centre from its true place, after `truth_from_model`.
inline double LargestCenterError(const Reconstruction& truth, const Reconstruction& model,
                                 const Sim3d& truth_from_model = {}) {
  double largest = 0;
  for (const auto& [id, image] : model.images) {
    const Eigen::Vector3d center = truth_from_model * CameraCenter(image.cam_from_world);
    const Eigen::Vector3d true_center = CameraCenter(truth.images.at(id).cam_from_world);
    largest = std::max(largest, (center - true_center).norm());
  }
  return largest;
}

}  // namespace colmap_ext
