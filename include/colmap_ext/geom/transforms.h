// Rigid and similarity transforms. A transform is named by both of its frames: with
// `cam_from_world`, `point_in_cam = cam_from_world * point_in_world`.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace colmap_ext {

struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
};

// c_from_b * b_from_a = c_from_a
Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a);
Rigid3d Inverse(const Rigid3d& b_from_a);

// x_in_b = scale * rotation * x_in_a + translation
struct Sim3d {
  double scale = 1.0;  // > 0
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
};

Sim3d operator*(const Sim3d& c_from_b, const Sim3d& b_from_a);
Sim3d Inverse(const Sim3d& b_from_a);

// The camera pose after the world was moved: cam_from_new for a camera given as cam_from_old. The
// camera centre moves by `new_from_old`; the camera keeps its own metric (COLMAP's convention).
Rigid3d TransformCameraWorld(const Sim3d& new_from_old, const Rigid3d& cam_from_old);

// Centre of the camera, in world coordinates.
Eigen::Vector3d CameraCenter(const Rigid3d& cam_from_world);

// Heading and pitch of a camera without roll in the ENU world (x east, y north, z up).
// yaw_rad: clockwise from north seen from above (0 north, pi/2 east). pitch_rad: 0 level, positive
// up.
struct ViewDirection {
  double yaw_rad = 0;
  double pitch_rad = 0;
};

// Unit vector along which the camera looks, in ENU.
Eigen::Vector3d DirectionInWorld(const ViewDirection& direction);
// Camera frame: x right, y down, z forward. Image x stays level (no roll). At pitch = ±pi/2 the top
// of the image points to (or away from) the heading yaw_rad.
Rigid3d CamFromWorld(const Eigen::Vector3d& position_in_world, const ViewDirection& direction);
// Inverse of the above; roll is dropped.
ViewDirection ViewDirectionOf(const Rigid3d& cam_from_world);

// Least-squares similarity: dst ~ result * src (Umeyama 1991). Columns are points, 3 x n, n >= 3.
// Throws Error when the points are collinear or fewer than 3.
Sim3d EstimateSimilarity(const Eigen::Matrix3Xd& src, const Eigen::Matrix3Xd& dst);

inline double DegToRad(double deg) { return deg * 0.017453292519943295; }
inline double RadToDeg(double rad) { return rad * 57.29577951308232; }
// Into (-pi, pi].
double NormalizeAngle(double rad);

}  // namespace colmap_ext
