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

std::size_t PixelIndex(int row, int col) { return static_cast<std::size_t>(row * kWidth + col); }
std::size_t CornerIndex(int row, int col) {
  return static_cast<std::size_t>(row * (kWidth + 1) + col);
}

// A convex polygon of at most four corners: pixel coordinates and inverse depth.
struct Polygon {
  std::array<Eigen::Vector3d, 4> corners;
  int size = 0;
};

// Pixel coordinates and inverse depth.
Eigen::Vector3d OnScreen(const Eigen::Vector3d& in_cam, const PinholeCamera& camera) {
  const double inverse_depth = 1 / in_cam.z();
  return {camera.fx * in_cam.x() * inverse_depth + camera.cx,
          camera.fy * in_cam.y() * inverse_depth + camera.cy, inverse_depth};
}

// Part of the triangle (camera frame) with z >= kNear_m.
Polygon CutAtNearPlane(const std::array<const Eigen::Vector3d*, 3>& triangle,
                       const PinholeCamera& camera) {
  Polygon polygon;
  const auto add = [&](const Eigen::Vector3d& point) {
    polygon.corners[static_cast<std::size_t>(polygon.size++)] = OnScreen(point, camera);
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

// The pixels that a box of pixel coordinates touches, and the corners in it: each is named like the
// pixel below and to the right of it, so there is one more row and column of them.
struct DepthRaster::PixelBox {
  template <typename Vector>
  PixelBox(const Vector& min, const Vector& max)
      : left(Floor(min.x(), 0, kWidth)),
        right(Floor(max.x(), 0, kWidth)),
        top(Floor(min.y(), 0, kHeight)),
        bottom(Floor(max.y(), 0, kHeight)),
        first_corner_col(left < min.x() ? left + 1 : left),
        first_corner_row(top < min.y() ? top + 1 : top) {}

  // One pixel, and none of its corners.
  bool IsOne() const {
    return left == right && top == bottom && left < kWidth && top < kHeight &&
           (first_corner_col > right || first_corner_row > bottom);
  }
  std::size_t First() const { return PixelIndex(top, left); }

  static int Floor(double value, double least, double most) {
    return static_cast<int>(std::clamp(value, least, most));  // none is negative
  }

  int left, right, top, bottom;            // all included
  int first_corner_col, first_corner_row;  // the last ones are right and bottom
};

// A vertex of the surface: camera frame, pixel coordinates and inverse depth; these mean nothing
// before the near plane.
struct DepthRaster::Vertex {
  Eigen::Vector3d in_cam;
  Eigen::Vector3d on_screen;
};

DepthRaster::DepthRaster(const FaceClusters& surface, const Rigid3d& cam_from_world,
                         const PinholeCamera& camera)
    : cam_from_world_(cam_from_world),
      camera_(ScaleTo(camera, kWidth, kHeight)),
      largest_inverse_depth_(std::size_t{kWidth} * kHeight, 0.0f),
      is_confident_(std::size_t{kWidth + 1} * (kHeight + 1), 0) {
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  const auto in_cam = [&](const Eigen::Vector3d& point) -> Eigen::Vector3d {
    return rotation * point + cam_from_world.translation;
  };
  struct Shown {
    double nearest_depth;
    Eigen::Vector3d center;  // camera frame
    const FaceClusters::Cluster* cluster;
  };
  std::vector<Shown> shown;
  for (const FaceClusters::Cluster& cluster : surface.clusters) {
    const Eigen::Vector3d center = in_cam(cluster.center);
    if (center.z() + cluster.radius_m < kNear_m || IsOutside(center, cluster.radius_m)) continue;
    shown.push_back({center.z() - cluster.radius_m, center, &cluster});
  }
  // Near ones first, so that they hide the others.
  std::stable_sort(shown.begin(), shown.end(), [](const Shown& a, const Shown& b) {
    return a.nearest_depth < b.nearest_depth;
  });
  std::vector<float> at_corner(is_confident_.size(), 0.0f);
  std::vector<Vertex> vertices;
  for (const auto& [nearest_depth, center, cluster] : shown) {
    if (IsHidden(center, cluster->radius_m, at_corner)) continue;
    vertices.clear();
    for (std::uint32_t v = cluster->first_vertex; v < cluster->end_vertex; ++v) {
      const Eigen::Vector3d vertex = in_cam(surface.vertices[v]);
      vertices.push_back({vertex, OnScreen(vertex, camera_)});
    }
    for (std::uint32_t f = cluster->first_face; f < cluster->end_face; ++f) {
      const FaceClusters::Face& face = surface.faces[f];
      Draw({&vertices[face.vertices[0]], &vertices[face.vertices[1]], &vertices[face.vertices[2]]},
           face.is_confident, &at_corner);
    }
  }
}

// No less than the half axes of the outline of a ball that is wholly before the camera: the slope
// of a ray to its rim changes by at most radius (1 + slope) / nearest depth.
Eigen::Vector2d DepthRaster::HalfAxes(const Eigen::Vector3d& center_in_cam, double radius_m) const {
  const double nearest_depth = center_in_cam.z() - radius_m;
  const double slope_x = std::abs(center_in_cam.x() / center_in_cam.z());
  const double slope_y = std::abs(center_in_cam.y() / center_in_cam.z());
  return {camera_.fx * radius_m * (1 + slope_x) / nearest_depth,
          camera_.fy * radius_m * (1 + slope_y) / nearest_depth};
}

// Whether the ball is beyond a side of the picture; not known of one around the camera.
bool DepthRaster::IsOutside(const Eigen::Vector3d& center_in_cam, double radius_m) const {
  if (center_in_cam.z() - radius_m <= std::max(radius_m, kNear_m)) return false;
  const Eigen::Vector2d pixel = camera_.Project(center_in_cam);
  const Eigen::Vector2d half = HalfAxes(center_in_cam, radius_m);
  return pixel.x() + half.x() < 0 || pixel.y() + half.y() < 0 || pixel.x() - half.x() > kWidth ||
         pixel.y() - half.y() > kHeight;
}

// Whether the ball, which is not outside, is behind all that is drawn there.
bool DepthRaster::IsHidden(const Eigen::Vector3d& center_in_cam, double radius_m,
                           const std::vector<float>& at_corner) const {
  const double nearest_depth = center_in_cam.z() - radius_m;
  if (nearest_depth <= std::max(radius_m, kNear_m)) return false;
  const Eigen::Vector2d pixel = camera_.Project(center_in_cam);
  const Eigen::Vector2d half = HalfAxes(center_in_cam, radius_m);
  const Eigen::Vector2d min = pixel - half, max = pixel + half;
  return IsHidden(PixelBox(min, max), static_cast<float>((1 + 1e-6) / nearest_depth), at_corner);
}

void DepthRaster::Draw(const std::array<const Vertex*, 3>& face, bool confident,
                       std::vector<float>* at_corner) {
  const double a = face[0]->in_cam.z(), b = face[1]->in_cam.z(), c = face[2]->in_cam.z();
  if (a < kNear_m && b < kNear_m && c < kNear_m) return;
  Polygon polygon;
  if (a >= kNear_m && b >= kNear_m && c >= kNear_m) {
    for (std::size_t i = 0; i < 3; ++i) polygon.corners[i] = face[i]->on_screen;
    polygon.size = 3;
  } else {
    polygon = CutAtNearPlane({&face[0]->in_cam, &face[1]->in_cam, &face[2]->in_cam}, camera_);
    if (polygon.size < 3) return;
  }
  Eigen::Vector3d min = polygon.corners[0], max = min;
  for (int i = 1; i < polygon.size; ++i) {
    min = min.cwiseMin(polygon.corners[static_cast<std::size_t>(i)]);
    max = max.cwiseMax(polygon.corners[static_cast<std::size_t>(i)]);
  }
  if (max.x() < 0 || max.y() < 0 || min.x() > kWidth || min.y() > kHeight) return;
  const PixelBox pixels(min, max);
  const auto nearest = static_cast<float>(max.z());
  if (pixels.IsOne()) {  // most faces are so small
    float& largest = largest_inverse_depth_[pixels.First()];
    largest = std::max(largest, nearest);
    return;
  }
  if (IsHidden(pixels, nearest, *at_corner)) return;
  const ScreenPolygon screen(polygon);
  for (int row = pixels.top; row <= std::min(pixels.bottom, kHeight - 1); ++row) {
    for (int col = pixels.left; col <= std::min(pixels.right, kWidth - 1); ++col) {
      SetNearest(screen, nearest, row, col);
    }
  }
  for (int row = pixels.first_corner_row; row <= pixels.bottom; ++row) {
    for (int col = pixels.first_corner_col; col <= pixels.right; ++col) {
      SetCorner(screen, row, col, confident, at_corner);
    }
  }
}

// Whether all that the pixels and their corners show so far is as near as that.
bool DepthRaster::IsHidden(const PixelBox& pixels, float inverse_depth,
                           const std::vector<float>& at_corner) const {
  for (int row = pixels.top; row <= std::min(pixels.bottom, kHeight - 1); ++row) {
    for (int col = pixels.left; col <= std::min(pixels.right, kWidth - 1); ++col) {
      if (largest_inverse_depth_[PixelIndex(row, col)] < inverse_depth) return false;
    }
  }
  for (int row = pixels.first_corner_row; row <= pixels.bottom; ++row) {
    for (int col = pixels.first_corner_col; col <= pixels.right; ++col) {
      if (at_corner[CornerIndex(row, col)] < inverse_depth) return false;
    }
  }
  return true;
}

// `most`: the inverse depth of the nearest corner of the polygon.
void DepthRaster::SetNearest(const ScreenPolygon& screen, float most, int row, int col) {
  float& largest = largest_inverse_depth_[PixelIndex(row, col)];
  if (most <= largest) return;
  const double x = col + 0.5, y = row + 0.5;
  const float nearest = std::min(most, static_cast<float>(screen.inverse_depth.Most(x, y)));
  if (nearest > largest && screen.Touches(x, y)) largest = nearest;
}

// The corner above and to the left of the pixel.
void DepthRaster::SetCorner(const ScreenPolygon& screen, int row, int col, bool confident,
                            std::vector<float>* at_corner) {
  const std::size_t corner = CornerIndex(row, col);
  const auto depth = static_cast<float>(screen.inverse_depth.At(col, row));
  if (depth <= (*at_corner)[corner] || !screen.Covers(col, row)) return;
  (*at_corner)[corner] = depth;
  is_confident_[corner] = confident ? 1 : 0;
}

bool DepthRaster::HasSeenPast(const Eigen::Vector3d& center, double radius_m) const {
  const Eigen::Vector3d center_in_cam = cam_from_world_ * center;
  // The ball must lie wholly in front of the camera for its outline to be a small ellipse.
  const double nearest_depth = center_in_cam.z() - radius_m;
  if (nearest_depth <= radius_m) return false;
  const Eigen::Vector2d pixel = camera_.Project(center_in_cam);
  const Eigen::Vector2d half = HalfAxes(center_in_cam, radius_m);
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
      if (is_confident_[CornerIndex(row, col)] == 0) return false;
      if (row > high.y() || col > high.x()) continue;
      if (largest_inverse_depth_[PixelIndex(row, col)] > limit) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace colmap_ext
