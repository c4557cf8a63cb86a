#include "colmap_ext/path/free_space.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr int kDepthWidth = 96;
constexpr int kDepthHeight = 54;

// Corners of a polyhedron inside the unit ball: towards the faces, edges and corners of a cube.
std::vector<Eigen::Vector3d> CornersInUnitBall() {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d corner(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (corner.norm() > 0) corners.push_back(corner.normalized());
  }
  return corners;
}

}  // namespace

std::string FreeSpaceOptions::Check() const {
  if (!(above_top_m >= 0)) return "above_top_m must be >= 0 (metres)";
  if (!(flown_margin_m >= 0)) return "flown_margin_m must be >= 0 (metres)";
  return "";
}

FreeSpace::FreeSpace(const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
                     const std::vector<Eigen::Vector3d>& flown, const FreeSpaceOptions& options)
    : ray_scene_(surface) {
  ThrowIfInvalid(options.Check());
  // With no surface nothing is known about heights.
  known_above_m_ = surface.vertices.empty() ? std::numeric_limits<double>::infinity()
                                            : BoundsOf(surface).max().z() + options.above_top_m;
  std::vector<Eigen::Vector3d> positions = flown;
  for (const PosedPhoto& photo : photos) positions.push_back(CameraCenter(photo.cam_from_world));
  hull_ = HullAround(positions, options.flown_margin_m);
  depth_views_.resize(photos.size());
  tbb::parallel_for(std::size_t{0}, photos.size(),
                    [&](std::size_t i) { depth_views_[i] = Look(ray_scene_, photos[i]); });
}

std::vector<FreeSpace::HalfSpace> FreeSpace::HullAround(
    const std::vector<Eigen::Vector3d>& positions, double margin_m) {
  // With corners around each position the hull has a volume even where all positions are in a
  // plane. Without a margin there is none to speak of.
  if (positions.empty() || margin_m <= 0) return {};
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> corners;
  for (const Eigen::Vector3d& position : positions) {
    for (const Eigen::Vector3d& corner : CornersInUnitBall()) {
      const Eigen::Vector3d p = position + margin_m * corner;
      corners.emplace_back(p.x(), p.y(), p.z());
    }
  }
  CGAL::Surface_mesh<Point> hull;
  CGAL::convex_hull_3(corners.begin(), corners.end(), hull);
  std::vector<HalfSpace> half_spaces;
  for (const auto face : hull.faces()) {
    std::vector<Eigen::Vector3d> p;
    for (const auto vertex : hull.vertices_around_face(hull.halfedge(face))) {
      const Point& point = hull.point(vertex);
      p.emplace_back(point.x(), point.y(), point.z());
    }
    const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (normal.norm() < 1e-12) continue;  // a sliver: its neighbours bound the same place
    half_spaces.push_back({normal.normalized(), normal.normalized().dot(p[0])});
  }
  return half_spaces;
}

FreeSpace::DepthView FreeSpace::Look(const RayScene& scene, const PosedPhoto& photo) {
  DepthView view;
  view.cam_from_world = photo.cam_from_world;
  view.camera = ScaleTo(photo.camera, kDepthWidth, kDepthHeight);
  view.distance_m.resize(std::size_t{kDepthWidth} * kDepthHeight);
  const Eigen::Vector3d center = CameraCenter(photo.cam_from_world);
  const Eigen::Quaterniond world_from_cam = photo.cam_from_world.rotation.conjugate();
  for (int row = 0; row < kDepthHeight; ++row) {
    for (int col = 0; col < kDepthWidth; ++col) {
      const Eigen::Vector3d ray = view.camera.Ray({col + 0.5, row + 0.5});
      const auto hit = scene.Intersect(center, world_from_cam * ray.normalized(), 0,
                                       std::numeric_limits<double>::infinity());
      view.distance_m[static_cast<std::size_t>(row * kDepthWidth + col)] =
          hit ? static_cast<float>(hit->distance_m) : 0.0f;
    }
  }
  return view;
}

bool FreeSpace::HasSeenPast(const DepthView& view, const Eigen::Vector3d& center, double radius_m) {
  const Eigen::Vector3d center_in_cam = view.cam_from_world * center;
  // The ball must lie wholly in front of the camera for its outline to be a small ellipse.
  const double nearest_depth = center_in_cam.z() - radius_m;
  if (nearest_depth <= radius_m) return false;
  const Eigen::Vector2d pixel = view.camera.Project(center_in_cam);
  // No less than the half axes of the outline: the slope of a ray to the ball's rim changes by at
  // most radius (1 + slope) / nearest depth.
  const double slope_x = std::abs(center_in_cam.x() / center_in_cam.z());
  const double slope_y = std::abs(center_in_cam.y() / center_in_cam.z());
  const Eigen::Vector2d half(view.camera.fx * radius_m * (1 + slope_x) / nearest_depth,
                             view.camera.fy * radius_m * (1 + slope_y) / nearest_depth);
  const Eigen::Vector2i low = (pixel - half).array().floor().cast<int>();
  const Eigen::Vector2i high = (pixel + half).array().floor().cast<int>();
  if (low.x() < 0 || low.y() < 0 || high.x() >= kDepthWidth || high.y() >= kDepthHeight) {
    return false;
  }
  const double beyond = center_in_cam.norm() + radius_m;
  for (int row = low.y(); row <= high.y(); ++row) {
    for (int col = low.x(); col <= high.x(); ++col) {
      const float distance = view.distance_m[static_cast<std::size_t>(row * kDepthWidth + col)];
      if (static_cast<double>(distance) < beyond) return false;
    }
  }
  return true;
}

bool FreeSpace::IsInHull(const Eigen::Vector3d& center, double radius_m) const {
  if (hull_.empty()) return false;
  return std::all_of(hull_.begin(), hull_.end(), [&](const HalfSpace& half_space) {
    return half_space.outwards.dot(center) + radius_m <= half_space.offset_m;
  });
}

bool FreeSpace::IsKnownFree(const Eigen::Vector3d& center, double radius_m) const {
  if (center.z() - radius_m >= known_above_m_) return true;
  if (IsInHull(center, radius_m)) return true;
  return std::any_of(depth_views_.begin(), depth_views_.end(),
                     [&](const DepthView& view) { return HasSeenPast(view, center, radius_m); });
}

}  // namespace colmap_ext
