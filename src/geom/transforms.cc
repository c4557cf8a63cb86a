#include "colmap_ext/geom/transforms.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
  Rigid3d c_from_a;
  c_from_a.rotation = (c_from_b.rotation * b_from_a.rotation).normalized();
  c_from_a.translation = c_from_b.rotation * b_from_a.translation + c_from_b.translation;
  return c_from_a;
}

Rigid3d Inverse(const Rigid3d& b_from_a) {
  Rigid3d a_from_b;
  a_from_b.rotation = b_from_a.rotation.conjugate();
  a_from_b.translation = -(a_from_b.rotation * b_from_a.translation);
  return a_from_b;
}

Sim3d operator*(const Sim3d& c_from_b, const Sim3d& b_from_a) {
  Sim3d c_from_a;
  c_from_a.scale = c_from_b.scale * b_from_a.scale;
  c_from_a.rotation = (c_from_b.rotation * b_from_a.rotation).normalized();
  c_from_a.translation = c_from_b * b_from_a.translation;
  return c_from_a;
}

Sim3d Inverse(const Sim3d& b_from_a) {
  Sim3d a_from_b;
  a_from_b.scale = 1.0 / b_from_a.scale;
  a_from_b.rotation = b_from_a.rotation.conjugate();
  a_from_b.translation = -a_from_b.scale * (a_from_b.rotation * b_from_a.translation);
  return a_from_b;
}

Rigid3d TransformCameraWorld(const Sim3d& new_from_old, const Rigid3d& cam_from_old) {
  Rigid3d cam_from_new;
  cam_from_new.rotation = (cam_from_old.rotation * new_from_old.rotation.conjugate()).normalized();
  const Eigen::Vector3d center_in_new = new_from_old * CameraCenter(cam_from_old);
  cam_from_new.translation = -(cam_from_new.rotation * center_in_new);
  return cam_from_new;
}

Eigen::Vector3d CameraCenter(const Rigid3d& cam_from_world) {
  return -(cam_from_world.rotation.conjugate() * cam_from_world.translation);
}

Eigen::Vector3d DirectionInWorld(const ViewDirection& direction) {
  const double horizontal = std::cos(direction.pitch_rad);
  return {horizontal * std::sin(direction.yaw_rad), horizontal * std::cos(direction.yaw_rad),
          std::sin(direction.pitch_rad)};
}

Rigid3d CamFromWorld(const Eigen::Vector3d& position_in_world, const ViewDirection& direction) {
  const Eigen::Vector3d forward = DirectionInWorld(direction);
  // Right of the heading, level: built from the yaw so that it exists at pitch = ±pi/2 too.
  const Eigen::Vector3d right(std::cos(direction.yaw_rad), -std::sin(direction.yaw_rad), 0.0);
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d cam_from_world_rotation;
  cam_from_world_rotation.row(0) = right;
  cam_from_world_rotation.row(1) = down;
  cam_from_world_rotation.row(2) = forward;
  Rigid3d cam_from_world;
  cam_from_world.rotation = Eigen::Quaterniond(cam_from_world_rotation).normalized();
  cam_from_world.translation = -(cam_from_world.rotation * position_in_world);
  return cam_from_world;
}

ViewDirection ViewDirectionOf(const Rigid3d& cam_from_world) {
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d forward = rotation.row(2);
  ViewDirection direction;
  direction.pitch_rad = std::asin(std::clamp(forward.z(), -1.0, 1.0));
  if (std::hypot(forward.x(), forward.y()) > 1e-6) {
    direction.yaw_rad = std::atan2(forward.x(), forward.y());
  } else {
    direction.yaw_rad = std::atan2(-rotation(0, 1), rotation(0, 0));  // from the right vector
  }
  return direction;
}

Sim3d EstimateSimilarity(const Eigen::Matrix3Xd& src, const Eigen::Matrix3Xd& dst) {
  if (src.cols() != dst.cols() || src.cols() < 3) {
    throw Error("a similarity needs at least 3 pairs of points");
  }
  const Eigen::Matrix3Xd centered = src.colwise() - src.rowwise().mean();
  const Eigen::Matrix3d scatter = centered * centered.transpose();
  const Eigen::Vector3d squared_extents =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(squared_extents(1) > 1e-12 * squared_extents(2))) {
    throw Error("a similarity cannot be found from points on one line");
  }
  const Eigen::Matrix4d dst_from_src = Eigen::umeyama(src, dst, true);
  Sim3d result;
  result.scale = std::cbrt(dst_from_src.topLeftCorner<3, 3>().determinant());
  result.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(dst_from_src.topLeftCorner<3, 3>() / result.scale))
          .normalized();
  result.translation = dst_from_src.topRightCorner<3, 1>();
  return result;
}

double NormalizeAngle(double rad) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  rad = std::fmod(rad, kTwoPi);
  if (rad <= -std::numbers::pi) rad += kTwoPi;
  if (rad > std::numbers::pi) rad -= kTwoPi;
  return rad;
}

}  // namespace colmap_ext
