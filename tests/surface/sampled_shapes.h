// Oriented points on shapes whose surface is known.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "colmap_ext/scene/oriented_points.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

inline OrientedPoint MakePoint(const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                               int photo_index = -1) {
  OrientedPoint point;
  point.position = position;
  point.normal = normal;
  point.color = {200, 100, 50};
  point.photo_index = photo_index;
  return point;
}

// A square grid of points at z = height over [x0, x1] x [y0, y1], normals up.
inline void AppendPlane(double x0, double y0, double x1, double y1, double height, double spacing,
                        int photo_index, OrientedPoints* points) {
  for (double x = x0 + 0.5 * spacing; x < x1; x += spacing) {
    for (double y = y0 + 0.5 * spacing; y < y1; y += spacing) {
      points->push_back(MakePoint({x, y, height}, Eigen::Vector3d::UnitZ(), photo_index));
    }
  }
}

inline OrientedPoints SpherePoints(const Eigen::Vector3d& center, double radius, int count,
                                   double noise_m) {
  OrientedPoints points;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    points.push_back(
        MakePoint(center + (radius + noise_m * normal(random)) * direction, direction, i % 5));
  }
  return points;
}

inline RegionOfInterest Region(const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  return {BoundingBox(min, max)};
}

}  // namespace colmap_ext
