// A wall with a step, photographed by a row of cameras: small, textured, with exact truth.
#pragma once

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "colmap_ext/dense/pair_stereo.h"
#include "colmap_ext/scene/reconstruction.h"
#include "mvs/analytic_scene.h"

namespace colmap_ext::test {

// A slanted wall 8 … 11 m north of the cameras, and a panel 2 m before it.
inline AnalyticScene WallScene() {
  AnalyticScene scene;
  scene.rectangles.push_back({{-9, 8, -7}, {18, 3, 0}, {0, 0, 14}, {110, 130, 120}, 1, 90, 0.35});
  scene.rectangles.push_back(
      {{-1.5, 6.5, -1.2}, {3, 0, 0}, {0, 0, 2.4}, {90, 90, 160}, 9, 90, 0.3});
  return scene;
}

inline PinholeCamera SmallCamera() { return {240, 160, 220, 220, 120, 80}; }

inline Rigid3d LookingNorthFrom(double x, double y, double z) {
  return CamFromWorld({x, y, z}, {0, 0});
}

inline AnalyticSurvey WallSurvey(int num_photos = 4) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < num_photos; ++i) {
    poses.push_back(LookingNorthFrom(0.8 * (i - 0.5 * (num_photos - 1)), 0, 0.1 * (i % 2)));
  }
  return Survey(WallScene(), SmallCamera(), poses, 600);
}

inline StereoView ViewOf(const PosedPhoto& photo) {
  StereoView view{photo.camera, photo.cam_from_world, cv::Mat()};
  cv::cvtColor(photo.bgr, view.gray, cv::COLOR_BGR2GRAY);
  return view;
}

inline StereoView ViewFrom(const Rigid3d& cam_from_world) {
  return ViewOf(Photograph(WallScene(), SmallCamera(), cam_from_world, "view.png").photo);
}

// How a map of inverse depths compares with true depths.
struct DepthScore {
  double valid = 0;         // share of pixels with truth that have a value
  double good = 0;          // share of these that are within 1 % of the truth
  double median_error = 0;  // relative, of those that have a value
};

inline DepthScore Score(const cv::Mat& inverse_depth, const cv::Mat1d& truth) {
  std::vector<double> errors;
  double total = 0, good = 0;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      if (!std::isfinite(truth(y, x))) continue;
      ++total;
      const float h = inverse_depth.at<float>(y, x);
      if (!(h > 0)) continue;
      errors.push_back(std::abs(1.0 / h / truth(y, x) - 1));
      good += errors.back() < 0.01;
    }
  }
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  return {count / total, good / count, errors[errors.size() / 2]};
}

// The survey as a sparse model, with its pictures in `folder`, `scale` times as large as the model.
inline Reconstruction WriteSurvey(const AnalyticScene& scene, const AnalyticSurvey& survey,
                                  const std::filesystem::path& folder, int scale = 1) {
  Reconstruction model;
  const PinholeCamera camera = survey.photos.photos[0].camera;
  model.cameras[1] = ToCamera(camera);
  std::filesystem::create_directories(folder);
  for (const PosedPhoto& photo : survey.photos.photos) {
    SparseImage image;
    image.name = photo.name;
    image.camera_id = 1;
    image.cam_from_world = photo.cam_from_world;
    model.images[photo.image_id] = image;
    const cv::Mat picture =
        scale == 1 ? photo.bgr
                   : Photograph(scene, ScaleTo(camera, scale * camera.width, scale * camera.height),
                                photo.cam_from_world, photo.name)
                         .photo.bgr;
    cv::imwrite((folder / photo.name).string(), picture);
  }
  Point3DId id = 0;
  for (const SupportPoint& point : survey.photos.points) {
    SparsePoint sparse;
    sparse.position = point.position;
    sparse.error_px = 0.1;
    for (const int i : point.photo_indices) {
      const PosedPhoto& photo = survey.photos.photos[static_cast<std::size_t>(i)];
      std::vector<Keypoint2D>& keypoints = model.images[photo.image_id].keypoints;
      sparse.track.push_back({photo.image_id, static_cast<std::uint32_t>(keypoints.size())});
      keypoints.push_back({camera.Project(photo.cam_from_world * point.position), id});
    }
    model.points[id++] = sparse;
  }
  return model;
}

}  // namespace colmap_ext::test
