// A hall in a wide plain: truth for tests of view planning.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "colmap_ext/nbv/next_best_views.h"

namespace colmap_ext {

// A hall of 24 x 10 x 12 m on wide ground, its faces split into squares with an iso-point each.
class HallWorld {
 public:
  HallWorld() {
    AddQuad({-60, -60, 0}, {120, 0, 0}, {0, 120, 0});  // ground
    AddFace({-12, -5, 0}, {24, 0, 0}, {0, 0, 12});     // south
    AddFace({12, 5, 0}, {-24, 0, 0}, {0, 0, 12});      // north
    AddFace({12, -5, 0}, {0, 10, 0}, {0, 0, 12});      // east
    AddFace({-12, 5, 0}, {0, -10, 0}, {0, 0, 12});     // west
    AddFace({-12, -5, 12}, {24, 0, 0}, {0, 10, 0});    // roof
    map.min_projection_ratio = 625;                    // 40 mm a pixel
    map.disk_area_m2 = 1;
  }

  void AddQuad(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {corner, corner + u, corner + u + v, corner + v});
    mesh.faces.emplace_back(first, first + 1, first + 2);
    mesh.faces.emplace_back(first, first + 2, first + 3);
  }

  void AddFace(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    AddQuad(corner, u, v);
    for (double s = 0.5; s < u.norm(); s += 1) {
      for (double t = 0.5; t < v.norm(); t += 1) {
        AddPoint(corner + s * u.normalized() + t * v.normalized(), u.cross(v).normalized());
      }
    }
  }

  void AddPoint(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
    IsoPoint point;
    point.position = position;
    point.normal = normal;
    point.coverage = CoverageClass::kCovered;
    map.points.push_back(point);
  }

  void Uncover(const Eigen::AlignedBox3d& box) {
    for (IsoPoint& point : map.points) {
      if (box.contains(point.position)) point.coverage = CoverageClass::kUncovered;
    }
  }

  TriangleMesh mesh;
  CoverageMap map;
};

inline double DistanceToHall(const Eigen::Vector3d& p) {
  const Eigen::AlignedBox3d hall(Eigen::Vector3d(-12, -5, 0), Eigen::Vector3d(12, 5, 12));
  return std::min(p.z(), hall.exteriorDistance(p));
}

inline const PinholeCamera kCamera{640, 368, 467, 467, 320, 184};

inline PosedPhoto PhotoAt(const Eigen::Vector3d& position, double yaw_deg, double pitch_deg) {
  PosedPhoto photo;
  photo.camera = kCamera;
  photo.cam_from_world = CamFromWorld(position, {DegToRad(yaw_deg), DegToRad(pitch_deg)});
  return photo;
}

// A line of photos south of the hall, looking north.
inline std::vector<PosedPhoto> SouthLine(double z = 15, double pitch_deg = -30) {
  std::vector<PosedPhoto> photos;
  for (double x = -14; x <= 14; x += 2) photos.push_back(PhotoAt({x, -15, z}, 0, pitch_deg));
  return photos;
}

// All around, looking inward.
inline std::vector<PosedPhoto> Ring() {
  std::vector<PosedPhoto> photos = SouthLine();
  for (double x = -14; x <= 14; x += 2) photos.push_back(PhotoAt({x, 15, 15}, 180, -30));
  for (double y = -7; y <= 7; y += 2) {
    photos.push_back(PhotoAt({22, y, 15}, -90, -30));
    photos.push_back(PhotoAt({-22, y, 15}, 90, -30));
  }
  return photos;
}

inline Rigid3d PoseOf(const PlannedView& view) {
  return CamFromWorld(view.position, view.direction);
}

// Seen in the hall's world, by geometry: convex, so facing and in the image is all.
inline bool Sees(const Rigid3d& cam_from_world, const IsoPoint& point) {
  const Eigen::Vector3d in_cam = cam_from_world * point.position;
  const Eigen::Vector3d to_camera = CameraCenter(cam_from_world) - point.position;
  const double cos_incidence = point.normal.dot(to_camera.normalized());
  return in_cam.z() > 0 && kCamera.Contains(kCamera.Project(in_cam), 4) &&
         cos_incidence > std::cos(DegToRad(80));
}

inline double Ratio(const Rigid3d& cam_from_world, const IsoPoint& point) {
  const Eigen::Vector3d to_camera = CameraCenter(cam_from_world) - point.position;
  const double depth = (cam_from_world * point.position).z();
  return kCamera.fx * kCamera.fy * point.normal.dot(to_camera) / std::pow(depth, 3);
}

// Marks the points that have a good pair of views, by the paper's rule, independently of the code.
inline void Evaluate(const std::vector<PosedPhoto>& photos, CoverageMap* map) {
  for (IsoPoint& point : map->points) {
    std::vector<Eigen::Vector3d> good;
    for (const PosedPhoto& photo : photos) {
      if (Sees(photo.cam_from_world, point) && Ratio(photo.cam_from_world, point) >= 625) {
        good.push_back((CameraCenter(photo.cam_from_world) - point.position).normalized());
      }
    }
    point.coverage = CoverageClass::kUncovered;
    for (std::size_t i = 0; i < good.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double angle = RadToDeg(std::acos(std::min(1.0, good[i].dot(good[j]))));
        if (angle >= 2 && angle <= 30) point.coverage = CoverageClass::kCovered;
      }
    }
  }
}

// With no sparse points: iso-points stand for features.
inline ViewPlanResult Plan(const CoverageMap& coverage, const TriangleMesh& surface,
                           const std::vector<PosedPhoto>& existing, const PinholeCamera& camera,
                           int first_id, const NextBestViewOptions& options,
                           const JobControl& job) {
  ViewPlanInput input{coverage, surface, existing};
  input.camera = camera;
  input.first_id = first_id;
  return PlanNextViews(input, options, job);
}

}  // namespace colmap_ext
