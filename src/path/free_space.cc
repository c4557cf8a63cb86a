#include "colmap_ext/path/free_space.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <sstream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "path/depth_raster.h"

namespace colmap_ext {
namespace {

// Corners of a polyhedron inside the unit ball: towards the faces, edges and corners of a cube.
std::vector<Eigen::Vector3d> CornersInUnitBall() {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d corner(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (corner.norm() > 0) corners.push_back(corner.normalized());
  }
  return corners;
}

struct HalfSpace {
  Eigen::Vector3d outwards;  // unit
  double offset_m = 0;       // inside: outwards . point <= offset_m
};

std::vector<HalfSpace> HullAround(const std::vector<Eigen::Vector3d>& positions, double margin_m) {
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

// One a face: all its corners have support that is dense enough. Empty: all faces are confident.
std::vector<bool> ConfidentFaces(const Surface& surface, double spacing_m) {
  if (spacing_m <= 0 || surface.sample_spacing_m.empty()) return {};
  std::vector<bool> confident;
  confident.reserve(surface.mesh.faces.size());
  for (const Eigen::Vector3i& face : surface.mesh.faces) {
    double widest = 0;
    for (const int vertex : face) {
      widest = std::max(widest, surface.sample_spacing_m[static_cast<std::size_t>(vertex)]);
    }
    confident.push_back(widest <= spacing_m);
  }
  return confident;
}

FlightZone ParseFreeBox(const std::string& text) {
  std::array<double, 6> v{};
  char rest = 0;
  const int count = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &v[0], &v[1], &v[2],
                                &v[3], &v[4], &v[5], &rest);
  BoundingBox box;
  box.extend(Eigen::Vector3d(v[0], v[1], v[2])).extend(Eigen::Vector3d(v[3], v[4], v[5]));
  if (count != 6 || !box.min().allFinite() || !box.max().allFinite()) {
    throw UsageError(
        "Path.free_volume: \"" + text +
        "\" must be flown, above_top, none, a box x,y,z,x,y,z in metres, or a GeoJSON file");
  }
  const Eigen::Vector3d& low = box.min();
  const Eigen::Vector3d& high = box.max();
  FlightZone zone;
  zone.rings = {
      {{low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}}};
  zone.min_z_m = low.z();
  zone.max_z_m = high.z();
  return zone;
}

}  // namespace

std::string FreeSpaceOptions::Check() const {
  if (!std::isfinite(above_top_m)) return "above_top_m must be finite (metres)";
  if (!(flown_margin_m >= 0)) return "flown_margin_m must be >= 0 (metres)";
  if (!(visited_margin_m >= 0)) return "visited_margin_m must be >= 0 (metres)";
  if (!(confident_spacing_m >= 0)) return "confident_spacing_m must be >= 0 (metres)";
  return "";
}

std::vector<std::filesystem::path> SetFreeVolume(const std::string& text,
                                                 FreeSpaceOptions* options) {
  bool flown = false, above_top = false;
  std::vector<std::filesystem::path> files;
  std::istringstream pieces(text);
  for (std::string piece; std::getline(pieces, piece, ';');) {
    if (piece == "flown") {
      flown = true;
    } else if (piece == "above_top") {
      above_top = true;
    } else if (piece.ends_with("json")) {
      files.emplace_back(piece);
    } else if (piece != "none" && !piece.empty()) {
      options->zones.push_back(ParseFreeBox(piece));
    }
  }
  if (!flown) options->flown_margin_m = 0;
  if (!above_top) options->above_top_m = -1;
  return files;
}

struct FreeSpace::Impl {
  explicit Impl(const TriangleMesh& mesh) : ray_scene(mesh) {
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
      normals.push_back(FaceNormal(mesh, face));
    }
  }

  RayScene ray_scene;
  std::vector<Eigen::Vector3d> normals;  // unit, one a face
  Eigen::AlignedBox3d bounds;
  double surface_top_m = -std::numeric_limits<double>::infinity();
  double known_above_m = std::numeric_limits<double>::infinity();  // z of the world
  std::vector<HalfSpace> hull;  // of the vouched places, margin included; empty: there are none
  std::vector<Eigen::Vector3d> visited;
  double visited_margin_m = 0;
  std::vector<FlightZone> zones;
  std::vector<DepthRaster> views;

  bool IsInHull(const Eigen::Vector3d& center, double radius_m) const {
    return !hull.empty() && std::all_of(hull.begin(), hull.end(), [&](const HalfSpace& half) {
      return half.outwards.dot(center) + radius_m <= half.offset_m;
    });
  }

  bool WasVisited(const Eigen::Vector3d& center, double radius_m) const {
    return std::any_of(visited.begin(), visited.end(), [&](const Eigen::Vector3d& place) {
      return (center - place).norm() + radius_m <= visited_margin_m;
    });
  }
};

FreeSpace::FreeSpace(const Surface& surface, const std::vector<PosedPhoto>& photos,
                     const FlownPlaces& flown, const FreeSpaceOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!surface.sample_spacing_m.empty() &&
      surface.sample_spacing_m.size() != surface.mesh.vertices.size()) {
    throw Error("path: the surface has not one sample spacing a vertex");
  }
  impl_ = std::make_unique<Impl>(surface.mesh);
  // With no surface nothing is known about heights.
  if (!surface.mesh.vertices.empty()) {
    impl_->bounds = BoundsOf(surface.mesh);
    impl_->surface_top_m = impl_->bounds.max().z();
    if (options.above_top_m >= 0) {
      impl_->known_above_m = impl_->surface_top_m + options.above_top_m;
    }
  }
  for (const Eigen::Vector3d& place : flown.vouched) impl_->bounds.extend(place);
  for (const Eigen::Vector3d& place : flown.visited) impl_->bounds.extend(place);
  impl_->hull = HullAround(flown.vouched, options.flown_margin_m);
  impl_->visited = flown.visited;
  impl_->visited_margin_m = options.visited_margin_m;
  impl_->zones = options.zones;
  if (photos.empty()) return;
  const FaceClusters clusters(surface.mesh, ConfidentFaces(surface, options.confident_spacing_m));
  std::vector<std::optional<DepthRaster>> views(photos.size());
  ParallelFor(photos.size(), [&](std::size_t i) {
    views[i].emplace(clusters, photos[i].cam_from_world, photos[i].camera);
  });
  for (auto& view : views) impl_->views.push_back(std::move(*view));
}

FreeSpace::~FreeSpace() = default;
FreeSpace::FreeSpace(FreeSpace&&) noexcept = default;
FreeSpace& FreeSpace::operator=(FreeSpace&&) noexcept = default;

bool FreeSpace::IsInsideSurface(const Eigen::Vector3d& point) const {
  int front = 0, back = 0;
  for (const Eigen::Vector3d& direction : CornersInUnitBall()) {
    const auto hit =
        impl_->ray_scene.Intersect(point, direction, 0, std::numeric_limits<double>::infinity());
    if (!hit) continue;
    const Eigen::Vector3d& normal = impl_->normals[static_cast<std::size_t>(hit->face)];
    (normal.dot(direction) > 0 ? back : front) += 1;
  }
  return back > front;
}

const RayScene& FreeSpace::ray_scene() const { return impl_->ray_scene; }
const Eigen::AlignedBox3d& FreeSpace::Bounds() const { return impl_->bounds; }
double FreeSpace::SurfaceTop() const { return impl_->surface_top_m; }

bool FreeSpace::IsKnownFree(const Eigen::Vector3d& center, double radius_m) const {
  if (center.z() - radius_m >= impl_->known_above_m) return true;
  for (const FlightZone& zone : impl_->zones) {
    if (zone.Depth(center) >= radius_m) return true;
  }
  if (impl_->IsInHull(center, radius_m) || impl_->WasVisited(center, radius_m)) return true;
  return std::any_of(impl_->views.begin(), impl_->views.end(),
                     [&](const DepthRaster& view) { return view.HasSeenPast(center, radius_m); });
}

}  // namespace colmap_ext
