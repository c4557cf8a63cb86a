#include "colmap_ext/coverage/visibility.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

double MedianEdgeLength(const TriangleMesh& mesh) {
  std::vector<double> lengths;
  lengths.reserve(mesh.faces.size() * 3);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const auto from = static_cast<std::size_t>(face[k]);
      const auto to = static_cast<std::size_t>(face[(k + 1) % 3]);
      lengths.push_back((mesh.vertices[to] - mesh.vertices[from]).norm());
    }
  }
  if (lengths.empty()) return 0;
  return MiddleValue(std::move(lengths));
}

// Poisson surfaces have edges of about the finest cell, and err by about that much; for a mesh with
// large facets the size of the whole says what "small" is.
double AutomaticEpsilon(const TriangleMesh& mesh) {
  if (mesh.faces.empty()) return 0;
  return std::min(MedianEdgeLength(mesh), 0.002 * BoundsOf(mesh).diagonal().norm());
}

}  // namespace

std::string VisibilityOptions::Check() const {
  if (!(epsilon_m >= 0)) return "epsilon_m must be >= 0 (metres; 0: automatic)";
  if (!(max_incidence_deg > 0 && max_incidence_deg <= 90)) {
    return "max_incidence_deg must be in (0, 90]";
  }
  if (!(border_px >= 0)) return "border_px must be >= 0";
  return "";
}

VisibilityEngine::VisibilityEngine(const TriangleMesh& mesh, const VisibilityOptions& options)
    : ray_scene_(mesh) {
  ThrowIfInvalid(options.Check());
  epsilon_m_ = options.epsilon_m > 0 ? options.epsilon_m : AutomaticEpsilon(mesh);
  min_cos_incidence_ = std::cos(DegToRad(options.max_incidence_deg));
  border_px_ = options.border_px;
}

bool VisibilityEngine::IsInView(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                                const Eigen::Vector3d& position,
                                const Eigen::Vector3d& normal) const {
  const Eigen::Vector3d position_in_cam = cam_from_world * position;
  if (position_in_cam.z() <= 0) return false;
  if (!camera.Contains(camera.Project(position_in_cam), border_px_)) return false;
  const double facing = -(cam_from_world.rotation * normal).dot(position_in_cam);
  return facing > 0 && facing >= min_cos_incidence_ * position_in_cam.norm();
}

bool VisibilityEngine::IsUnoccluded(const Eigen::Vector3d& camera_center,
                                    const Eigen::Vector3d& position,
                                    const Eigen::Vector3d& normal) const {
  return !ray_scene_.IsOccluded(camera_center, position + epsilon_m_ * normal, epsilon_m_);
}

bool VisibilityEngine::IsVisible(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                                 const Eigen::Vector3d& position,
                                 const Eigen::Vector3d& normal) const {
  return IsInView(camera, cam_from_world, position, normal) &&
         IsUnoccluded(CameraCenter(cam_from_world), position, normal);
}

}  // namespace colmap_ext
