// Scenes of textured rectangles with exact depth, photos of them by ray casting, and exact SfM
// points.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext::test {

// The rectangle origin + a u + b v, a and b in [0, 1]; u and v orthogonal.
struct Rectangle {
  Eigen::Vector3d origin, u, v;
  Eigen::Vector3d base_bgr = Eigen::Vector3d::Constant(128);
  std::uint32_t texture = 1;
  double contrast = 60;
  double grain_m = 0.15;  // size of the coarsest texture cell

  Eigen::Vector3d Normal() const { return u.cross(v).normalized(); }
};

struct Hit {
  double distance = std::numeric_limits<double>::infinity();  // in units of the direction
  int rectangle = -1;
  double a = 0, b = 0;
};

struct AnalyticScene {
  std::vector<Rectangle> rectangles;

  Hit Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    Hit best;
    for (std::size_t r = 0; r < rectangles.size(); ++r) {
      const Rectangle& rectangle = rectangles[r];
      const Eigen::Vector3d normal = rectangle.Normal();
      const double s = normal.dot(rectangle.origin - origin) / normal.dot(direction);
      if (!(s > 1e-9) || s >= best.distance) continue;
      const Eigen::Vector3d p = origin + s * direction - rectangle.origin;
      const double a = p.dot(rectangle.u) / rectangle.u.squaredNorm();
      const double b = p.dot(rectangle.v) / rectangle.v.squaredNorm();
      if (a < 0 || a > 1 || b < 0 || b > 1) continue;
      best = {s, static_cast<int>(r), a, b};
    }
    return best;
  }
};

inline double Noise(std::int64_t x, std::int64_t y, std::uint32_t seed) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
                    static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL ^ seed * 0x165667B1ULL;
  h ^= h >> 29;
  h *= 0xBF58476D1CE4E5B9ULL;
  h ^= h >> 32;
  return static_cast<double>(h & 0xFFFF) / 65535.0 - 0.5;
}

// Smooth noise in [-0.5, 0.5].
inline double SmoothNoise(double x, double y, std::uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
  const double s = x - fx, t = y - fy;
  const double top = (1 - s) * Noise(ix, iy, seed) + s * Noise(ix + 1, iy, seed);
  const double bottom = (1 - s) * Noise(ix, iy + 1, seed) + s * Noise(ix + 1, iy + 1, seed);
  return (1 - t) * top + t * bottom;
}

inline Eigen::Vector3d ColorAt(const Rectangle& rectangle, double a, double b) {
  const double x = a * rectangle.u.norm() / rectangle.grain_m;
  const double y = b * rectangle.v.norm() / rectangle.grain_m;
  const double value = SmoothNoise(x, y, rectangle.texture) +
                       0.6 * SmoothNoise(2.3 * x, 2.3 * y, rectangle.texture + 1) +
                       0.4 * SmoothNoise(5.1 * x, 5.1 * y, rectangle.texture + 2);
  return rectangle.base_bgr + Eigen::Vector3d::Constant(rectangle.contrast * value);
}

struct AnalyticView {
  PosedPhoto photo;
  cv::Mat1d depth;  // z at pixel centres; infinity where nothing is hit
};

inline AnalyticView Photograph(const AnalyticScene& scene, const PinholeCamera& camera,
                               const Rigid3d& cam_from_world, const std::string& name) {
  AnalyticView view;
  view.photo.name = name;
  view.photo.camera = camera;
  view.photo.cam_from_world = cam_from_world;
  view.photo.bgr.create(camera.height, camera.width, CV_8UC3);
  view.depth.create(camera.height, camera.width);
  const Rigid3d world_from_cam = Inverse(cam_from_world);
  const Eigen::Vector3d center = world_from_cam.translation;
  const auto cast = [&](double x, double y) {
    return scene.Cast(center, world_from_cam.rotation * camera.Ray({x, y}));
  };
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      view.depth(y, x) = cast(x + 0.5, y + 0.5).distance;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int s = 0; s < 4; ++s) {
        const Hit hit = cast(x + 0.25 + 0.5 * (s % 2), y + 0.25 + 0.5 * (s / 2));
        sum +=
            hit.rectangle < 0
                ? Eigen::Vector3d(235, 206, 180)
                : ColorAt(scene.rectangles[static_cast<std::size_t>(hit.rectangle)], hit.a, hit.b);
      }
      for (int c = 0; c < 3; ++c) {
        view.photo.bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(sum[c] / 4.0);
      }
    }
  }
  return view;
}

struct AnalyticSurvey {
  PhotoSet photos;
  std::vector<cv::Mat1d> depth;  // truth, one a photo
};

// Photos from the poses, and about `num_points` exact SfM points on surfaces that at least two of
// them see, thrown uniformly over the rectangles by area.
inline AnalyticSurvey Survey(const AnalyticScene& scene, const PinholeCamera& camera,
                             const std::vector<Rigid3d>& poses, int num_points,
                             std::uint32_t seed = 7) {
  AnalyticSurvey survey;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    AnalyticView view =
        Photograph(scene, camera, poses[i], "photo_" + std::to_string(100 + i) + ".png");
    view.photo.image_id = static_cast<ImageId>(i + 1);
    survey.photos.photos.push_back(view.photo);
    survey.depth.push_back(view.depth);
  }
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> areas;
  for (const Rectangle& r : scene.rectangles) areas.push_back(r.u.norm() * r.v.norm());
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  for (int attempt = 0; attempt < 50 * num_points; ++attempt) {
    if (static_cast<int>(survey.photos.points.size()) >= num_points) break;
    const Rectangle& r = scene.rectangles[pick(random)];
    SupportPoint point;
    const double a = uniform(random), b = uniform(random);
    point.position = r.origin + a * r.u + b * r.v;
    point.error_px = 0.3;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector3d in_cam = poses[i] * point.position;
      if (in_cam.z() < 0.1 || !camera.Contains(camera.Project(in_cam), 1.0)) continue;
      const Eigen::Vector3d center = CameraCenter(poses[i]);
      if (scene.Cast(center, point.position - center).distance < 1.0 - 1e-6) continue;
      point.photo_indices.push_back(static_cast<int>(i));
    }
    if (point.photo_indices.size() >= 2) survey.photos.points.push_back(point);
  }
  return survey;
}

inline PinholeCamera TestCamera(int width = 320, int height = 240, double focal_px = 300) {
  return {width, height, focal_px, focal_px, width / 2.0, height / 2.0};
}

// Camera at `position` that looks at `target`.
inline Rigid3d LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d d = (target - position).normalized();
  return CamFromWorld(position, {std::atan2(d.x(), d.y()), std::asin(d.z())});
}

}  // namespace colmap_ext::test
