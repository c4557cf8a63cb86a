#include "sim/face_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr int kRays = 48;
constexpr int kGroundRays = 16;
constexpr double kFar = 1e5;      // m: further than any scene
constexpr double kOffset = 2e-3;  // m: keeps a ray off the face that it starts from

// Ground faces up to this size are judged by their corners and centre; on larger ones each place
// is.
constexpr double kSmallGround = 0.5;  // m²

// What the corners and the centre of a ground face see.
enum class GroundView : std::uint8_t { kNoSky, kSomeSky, kSky };

class VisibilityTest {
 public:
  VisibilityTest(const TriangleMesh& mesh, const std::vector<int>& object_of_face)
      : mesh_(mesh),
        object_of_face_(object_of_face),
        rays_(mesh),
        has_ground_(std::count(object_of_face.begin(), object_of_face.end(), kGroundObject) > 0),
        ground_view_(mesh.faces.size(), GroundView::kNoSky) {
    ParallelFor(mesh.faces.size(), [&](std::size_t i) {
      if (object_of_face_[i] == kGroundObject) ground_view_[i] = ViewOfGround(i);
    });
  }

  bool FaceIsVisible(std::size_t face) const {
    const Eigen::Vector3d normal = FaceNormal(mesh_, face);
    if (normal.isZero()) return false;
    const Eigen::Matrix3d rotation = RotationFromZ(normal);
    for (const Eigen::Vector3d& point : PointsOf(face)) {
      if (PointIsVisible(point + kOffset * normal, rotation)) return true;
    }
    return false;
  }

 private:
  const Eigen::Vector3d& VertexAt(int i) const {
    return mesh_.vertices[static_cast<std::size_t>(i)];
  }

  // Three points a little inside the corners, and the centre.
  std::array<Eigen::Vector3d, 4> PointsOf(std::size_t face) const {
    const auto& f = mesh_.faces[face];
    const Eigen::Vector3d a = VertexAt(f[0]), b = VertexAt(f[1]), c = VertexAt(f[2]);
    const Eigen::Vector3d center = (a + b + c) / 3;
    return {center, center + 0.8 * (a - center), center + 0.8 * (b - center),
            center + 0.8 * (c - center)};
  }

  GroundView ViewOfGround(std::size_t face) const {
    const Eigen::Vector3d normal = FaceNormal(mesh_, face);
    if (normal.isZero()) return GroundView::kNoSky;
    int open = 0;
    for (const Eigen::Vector3d& point : PointsOf(face)) {
      if (SeesSky(point + kOffset * normal, RotationFromZ(normal))) ++open;
    }
    if (FaceArea(mesh_, face) > kSmallGround) return GroundView::kSomeSky;
    return open == 0 ? GroundView::kNoSky : open == 4 ? GroundView::kSky : GroundView::kSomeSky;
  }

  bool PointIsVisible(const Eigen::Vector3d& point, const Eigen::Matrix3d& rotation) const {
    for (const auto& local : directions_) {
      const Eigen::Vector3d direction = rotation * local;
      const auto hit = rays_.Intersect(point, direction, 0, kFar);
      if (!hit.has_value()) {
        // Below the horizon one only gets away from under the ground, or in a scene without any.
        if (has_ground_ && direction.z() < 0) continue;
        return true;
      }
      const auto face = static_cast<std::size_t>(hit->face);
      if (object_of_face_[face] != kGroundObject) continue;
      if (ground_view_[face] == GroundView::kNoSky) continue;
      const Eigen::Vector3d normal = FaceNormal(mesh_, face);
      if (normal.dot(direction) >= 0) continue;  // the ground's back
      if (ground_view_[face] == GroundView::kSky) return true;
      const Eigen::Vector3d at = point + hit->distance_m * direction + kOffset * normal;
      if (SeesSky(at, RotationFromZ(normal))) return true;
    }
    return false;
  }

  bool SeesSky(const Eigen::Vector3d& point, const Eigen::Matrix3d& rotation) const {
    for (const auto& local : ground_directions_) {
      if (!rays_.Intersect(point, rotation * local, 0, kFar).has_value()) return true;
    }
    return false;
  }

  const TriangleMesh& mesh_;
  const std::vector<int>& object_of_face_;
  RayScene rays_;
  std::vector<Eigen::Vector3d> directions_ = HemisphereDirections(kRays, false);
  std::vector<Eigen::Vector3d> ground_directions_ = HemisphereDirections(kGroundRays, false);
  bool has_ground_ = false;
  std::vector<GroundView> ground_view_;
};

}  // namespace

std::vector<Eigen::Vector3d> HemisphereDirections(int count, bool cosine_weighted) {
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double t = (i + 0.5) / count;
    const double z = cosine_weighted ? std::sqrt(1 - t) : 1 - t;
    const double radius = std::sqrt(1 - z * z);
    directions.emplace_back(radius * std::cos(kGoldenAngle * i),
                            radius * std::sin(kGoldenAngle * i), z);
  }
  return directions;
}

Eigen::Matrix3d RotationFromZ(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d hint =
      std::abs(normal.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d y = normal.cross(hint).normalized();
  Eigen::Matrix3d rotation;
  rotation << y.cross(normal), y, normal;
  return rotation;
}

std::vector<bool> FindVisibleFaces(const TriangleMesh& mesh,
                                   const std::vector<int>& object_of_face) {
  const VisibilityTest test(mesh, object_of_face);
  std::vector<std::uint8_t> visible(mesh.faces.size(), 1);  // not vector<bool>: written in parallel
  ParallelFor(mesh.faces.size(), [&](std::size_t i) {
    if (object_of_face[i] != kGroundObject) visible[i] = test.FaceIsVisible(i) ? 1 : 0;
  });
  return {visible.begin(), visible.end()};
}

void KeepFaces(const std::vector<bool>& keep, TexturedScene* scene) {
  TexturedScene kept;
  std::vector<int> new_index(scene->mesh.vertices.size(), -1);
  const bool with_normals = scene->vertex_normals.size() == scene->mesh.vertices.size();
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    Eigen::Vector3i face = scene->mesh.faces[i];
    for (int k = 0; k < 3; ++k) {
      const auto old = static_cast<std::size_t>(face[k]);
      if (new_index[old] < 0) {
        new_index[old] = static_cast<int>(kept.mesh.vertices.size());
        kept.mesh.vertices.push_back(scene->mesh.vertices[old]);
        if (with_normals) kept.vertex_normals.push_back(scene->vertex_normals[old]);
      }
      face[k] = new_index[old];
    }
    kept.mesh.faces.push_back(face);
    kept.corner_uv.push_back(scene->corner_uv[i]);
    kept.material_of_face.push_back(scene->material_of_face[i]);
    kept.object_of_face.push_back(scene->object_of_face[i]);
  }
  kept.materials = std::move(scene->materials);
  kept.origin = scene->origin;
  *scene = std::move(kept);
}

}  // namespace colmap_ext
