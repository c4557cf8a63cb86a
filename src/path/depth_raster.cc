#include "path/depth_raster.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace colmap_ext {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 54;
// Surface nearer to the camera than this is cut off.
constexpr double kNear_m = 0.05;

// A convex polygon of at most four corners: pixel coordinates and inverse depth.
struct Polygon {
  std::array<Eigen::Vector3d, 4> corners;
  int size = 0;
};

// Part of the triangle (camera frame) with z >= kNear_m.
Polygon CutAtNearPlane(const std::array<const Eigen::Vector3d*, 3>& triangle,
                       const PinholeCamera& camera) {
  Polygon polygon;
  const auto add = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector2d pixel = camera.Project(point);
    polygon.corners[static_cast<std::size_t>(polygon.size++)] << pixel, 1 / point.z();
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& from = *triangle[i];
    const Eigen::Vector3d& to = *triangle[(i + 1) % 3];
    if (from.z() >= kNear_m) add(from);
    if ((from.z() >= kNear_m) != (to.z() >= kNear_m)) {
      Eigen::Vector3d cut = from + (kNear_m - from.z()) / (to.z() - from.z()) * (to - from);
      cut.z() = kNear_m;
      add(cut);
    }
  }
  return polygon;
}

// Inside: a x + b y + c >= 0.
struct Edge {
  double a = 0, b = 0, c = 0;
  double At(double x, double y) const { return a * x + b * y + c; }
  // The largest value on the unit square around the centre (x, y).
  double Most(double x, double y) const { return At(x, y) + (std::abs(a) + std::abs(b)) / 2; }
};

}  // namespace

// Edges of the polygon, either way round, and its inverse depth, affine in pixel coordinates.
struct DepthRaster::ScreenPolygon {
  explicit ScreenPolygon(const Polygon& polygon) : size(static_cast<std::size_t>(polygon.size)) {
    double area = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const Eigen::Vector3d& p = polygon.corners[i];
      const Eigen::Vector3d& q = polygon.corners[(i + 1) % size];
      edges[i] = {p.y() - q.y(), q.x() - p.x(), p.x() * q.y() - q.x() * p.y()};
      area += edges[i].c;
      most_inverse = std::max(most_inverse, p.z());
    }
    if (area < 0) {
      for (Edge& edge : edges) edge = {-edge.a, -edge.b, -edge.c};
    }
    SetInverseDepth(polygon);
  }

  bool Covers(double x, double y) const {
    return std::all_of(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(size),
                       [&](const Edge& edge) { return edge.At(x, y) >= 0; });
  }
  // Any of the unit square around (x, y).
  bool Touches(double x, double y) const {
    return std::all_of(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(size),
                       [&](const Edge& edge) { return edge.Most(x, y) >= 0; });
  }

  // Where the surface is seen edge on the plane is no function of the pixel: everything counts as
  // its nearest corner.
  void SetInverseDepth(const Polygon& polygon) {
    inverse_depth = {0, 0, most_inverse};
    double best = 1e-6;
    for (std::size_t i = 1; i + 1 < size; ++i) {
      const Eigen::Vector3d u = polygon.corners[i] - polygon.corners[0];
      const Eigen::Vector3d v = polygon.corners[i + 1] - polygon.corners[0];
      const Eigen::Vector3d normal = u.cross(v);
      if (std::abs(normal.z()) <= best) continue;
      best = std::abs(normal.z());
      const double a = -normal.x() / normal.z();
      const double b = -normal.y() / normal.z();
      inverse_depth = {
          a, b, polygon.corners[0].z() - a * polygon.corners[0].x() - b * polygon.corners[0].y()};
    }
  }

  std::array<Edge, 4> edges;
  std::size_t size = 0;
  Edge inverse_depth;
  double most_inverse = 0;
};

namespace {

// Pixels from `low` to `high` (both included) of an axis that [min, max] touches.
void PixelRange(double min, double max, int size, int* low, int* high) {
  *low = static_cast<int>(std::floor(std::clamp(min, -1.0, size + 1.0)));
  *high = static_cast<int>(std::floor(std::clamp(max, -1.0, size + 1.0)));
}

}  // namespace

DepthRaster::DepthRaster(const TriangleMesh& surface, const std::vector<bool>& confident,
                         const Rigid3d& cam_from_world, const PinholeCamera& camera)
    : cam_from_world_(cam_from_world),
      camera_(ScaleTo(camera, kWidth, kHeight)),
      largest_inverse_depth_(std::size_t{kWidth} * kHeight, 0.0f),
      is_confident_(std::size_t{kWidth + 1} * (kHeight + 1), 0) {
  std::vector<float> at_corner(is_confident_.size(), 0.0f);
  std::vector<Eigen::Vector3d> in_cam(surface.vertices.size());
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  for (std::size_t i = 0; i < in_cam.size(); ++i) {
    in_cam[i] = rotation * surface.vertices[i] + cam_from_world.translation;
  }
  for (std::size_t f = 0; f < surface.faces.size(); ++f) {
    const Eigen::Vector3i& face = surface.faces[f];
    Draw(in_cam[static_cast<std::size_t>(face[0])], in_cam[static_cast<std::size_t>(face[1])],
         in_cam[static_cast<std::size_t>(face[2])], confident.empty() || confident[f], &at_corner);
  }
}

void DepthRaster::Draw(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       bool confident, std::vector<float>* at_corner) {
  if (a.z() < kNear_m && b.z() < kNear_m && c.z() < kNear_m) return;
  const Polygon polygon = CutAtNearPlane({&a, &b, &c}, camera_);
  if (polygon.size < 3) return;
  Eigen::Vector2d min = polygon.corners[0].head<2>(), max = min;
  for (int i = 1; i < polygon.size; ++i) {
    min = min.cwiseMin(polygon.corners[static_cast<std::size_t>(i)].head<2>());
    max = max.cwiseMax(polygon.corners[static_cast<std::size_t>(i)].head<2>());
  }
  if (max.x() < 0 || max.y() < 0 || min.x() > kWidth || min.y() > kHeight) return;
  const ScreenPolygon screen(polygon);
  int left = 0, right = 0, top = 0, bottom = 0;
  PixelRange(min.x(), max.x(), kWidth, &left, &right);
  PixelRange(min.y(), max.y(), kHeight, &top, &bottom);
  for (int row = std::max(0, top); row <= std::min(kHeight, bottom + 1); ++row) {
    for (int col = std::max(0, left); col <= std::min(kWidth, right + 1); ++col) {
      if (row < kHeight && col < kWidth) SetNearest(screen, row, col);
      const auto corner = static_cast<std::size_t>(row * (kWidth + 1) + col);
      const auto depth = static_cast<float>(screen.inverse_depth.At(col, row));
      if (depth <= (*at_corner)[corner] || !screen.Covers(col, row)) continue;
      (*at_corner)[corner] = depth;
      is_confident_[corner] = confident ? 1 : 0;
    }
  }
}

void DepthRaster::SetNearest(const ScreenPolygon& screen, int row, int col) {
  const double x = col + 0.5, y = row + 0.5;
  if (!screen.Touches(x, y)) return;
  const double nearest = std::min(screen.most_inverse, screen.inverse_depth.Most(x, y));
  float& largest = largest_inverse_depth_[static_cast<std::size_t>(row * kWidth + col)];
  largest = std::max(largest, static_cast<float>(nearest));
}

bool DepthRaster::HasSeenPast(const Eigen::Vector3d& center, double radius_m) const {
  const Eigen::Vector3d center_in_cam = cam_from_world_ * center;
  // The ball must lie wholly in front of the camera for its outline to be a small ellipse.
  const double nearest_depth = center_in_cam.z() - radius_m;
  if (nearest_depth <= radius_m) return false;
  const Eigen::Vector2d pixel = camera_.Project(center_in_cam);
  // No less than the half axes of the outline: the slope of a ray to the ball's rim changes by at
  // most radius (1 + slope) / nearest depth.
  const double slope_x = std::abs(center_in_cam.x() / center_in_cam.z());
  const double slope_y = std::abs(center_in_cam.y() / center_in_cam.z());
  const Eigen::Vector2d half(camera_.fx * radius_m * (1 + slope_x) / nearest_depth,
                             camera_.fy * radius_m * (1 + slope_y) / nearest_depth);
  if (!((pixel - half).minCoeff() >= 0) || !(pixel.x() + half.x() < kWidth) ||
      !(pixel.y() + half.y() < kHeight)) {
    return false;
  }
  const Eigen::Vector2i low = (pixel - half).array().floor().cast<int>();
  const Eigen::Vector2i high = (pixel + half).array().floor().cast<int>();
  // The rounding of the float is taken off.
  const auto limit = static_cast<float>((1 - 1e-6) / (center_in_cam.z() + radius_m));
  for (int row = low.y(); row <= high.y() + 1; ++row) {
    for (int col = low.x(); col <= high.x() + 1; ++col) {
      if (is_confident_[static_cast<std::size_t>(row * (kWidth + 1) + col)] == 0) return false;
      if (row > high.y() || col > high.x()) continue;
      if (largest_inverse_depth_[static_cast<std::size_t>(row * kWidth + col)] > limit) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace colmap_ext
