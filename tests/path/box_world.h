// Worlds of boxes for path tests, with distances that do not use the code under test.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

// A block of 10 x 10 x 10 m on the ground.
inline const std::vector<Eigen::AlignedBox3d> kBlock = {
    {Eigen::Vector3d(-5, -5, 0), Eigen::Vector3d(5, 5, 10)}};

// Flying is allowed wherever nothing is seen, 2 m from the surface.
inline PathOptions Everywhere() {
  PathOptions options;
  options.unknown = "free";
  options.safe_distance_m = 2;
  options.position_error_m = 0;
  return options;
}

inline bool Says(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

inline void AddBox(const Eigen::AlignedBox3d& box, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (int i = 0; i < 8; ++i) {
    mesh->vertices.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
  // Corner i has x high for bit 0, y high for bit 1, z high for bit 2.
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh->faces.emplace_back(first + q[0], first + q[1], first + q[2]);
    mesh->faces.emplace_back(first + q[0], first + q[2], first + q[3]);
  }
}

inline TriangleMesh MeshOf(const std::vector<Eigen::AlignedBox3d>& boxes) {
  TriangleMesh mesh;
  for (const Eigen::AlignedBox3d& box : boxes) AddBox(box, &mesh);
  return mesh;
}

inline Surface SurfaceOf(const std::vector<Eigen::AlignedBox3d>& boxes) { return {MeshOf(boxes)}; }

// Distance to the nearest box; 0 inside.
inline double DistanceToBoxes(const std::vector<Eigen::AlignedBox3d>& boxes,
                              const Eigen::Vector3d& point) {
  double distance = 1e9;
  for (const Eigen::AlignedBox3d& box : boxes) {
    distance = std::min(distance, box.exteriorDistance(point));
  }
  return distance;
}

// Least distance over the path, sampled every centimetre.
inline double SampledClearance(const std::vector<Eigen::AlignedBox3d>& boxes,
                               const std::vector<Waypoint>& waypoints) {
  double clearance = 1e9;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Eigen::Vector3d& a = waypoints[i].position;
    const Eigen::Vector3d& b = waypoints[std::min(i + 1, waypoints.size() - 1)].position;
    const int steps = 1 + static_cast<int>((b - a).norm() / 0.01);
    for (int k = 0; k <= steps; ++k) {
      clearance = std::min(clearance, DistanceToBoxes(boxes, a + (b - a) * k / steps));
    }
  }
  return clearance;
}

inline PlannedView ViewAt(int id, double x, double y, double z, double yaw_rad = 0) {
  PlannedView view;
  view.id = id;
  view.position << x, y, z;
  view.direction.yaw_rad = yaw_rad;
  return view;
}

inline PosedPhoto PhotoAt(const Eigen::Vector3d& position, double yaw_deg, double pitch_deg) {
  PosedPhoto photo;
  photo.camera = {640, 368, 500, 500, 320, 184};
  photo.cam_from_world = CamFromWorld(position, {DegToRad(yaw_deg), DegToRad(pitch_deg)});
  return photo;
}

}  // namespace colmap_ext
