#include "sim/camera_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace colmap_ext {
namespace {

// The pose `time_s` after the middle of the exposure.
Rigid3d MovedPose(const Rigid3d& cam_from_world, const CameraMotion& motion, double time_s) {
  const double angle = motion.angular_rate_in_cam.norm() * time_s;
  const Eigen::Vector3d axis = motion.angular_rate_in_cam.normalized();
  const Eigen::Vector3d center = CameraCenter(cam_from_world) + time_s * motion.velocity_in_world;
  Rigid3d moved;
  // The camera turns by `angle` in its own frame, so the world turns back.
  moved.rotation =
      angle == 0 ? cam_from_world.rotation
                 : Eigen::Quaterniond(Eigen::AngleAxisd(-angle, axis)) * cam_from_world.rotation;
  moved.translation = -(moved.rotation * center);
  return moved;
}

// Times in (-0.5, 0.5) of a pixel's samples, evenly spaced and in an order without relation to
// their places.
std::vector<double> SampleTimes(int count) {
  std::vector<double> key(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < key.size(); ++k) {
    key[k] = std::fmod(static_cast<double>(k) * 0.6180339887498949, 1.0);
  }
  std::vector<std::size_t> order(key.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&key](std::size_t a, std::size_t b) { return key[a] < key[b]; });
  std::vector<double> times(key.size());
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    times[order[rank]] = (static_cast<double>(rank) + 0.5) / count - 0.5;
  }
  return times;
}

}  // namespace

CameraRays::CameraRays(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                       int samples_per_axis, const CameraMotion& motion, double shutter_s)
    : camera_(camera), n_(samples_per_axis) {
  const bool moves =
      shutter_s > 0 && (!motion.velocity_in_world.isZero() || !motion.angular_rate_in_cam.isZero());
  const std::vector<double> times = moves ? SampleTimes(n_ * n_) : std::vector<double>{0};
  for (const double time : times) {
    const Rigid3d pose = MovedPose(cam_from_world, motion, time * shutter_s);
    poses_.push_back({pose.rotation.toRotationMatrix().transpose().cast<float>(),
                      CameraCenter(pose).cast<float>()});
  }
}

void CameraRays::FillPacket(int i0, int j0, RTCRayHit16* rays, int* valid) const {
  const auto inv_fx = static_cast<float>(1 / camera_.fx);
  const auto inv_fy = static_cast<float>(1 / camera_.fy);
  for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
    const int i = i0 + lane % kBlock, j = j0 + lane / kBlock;
    valid[lane] = i < width() && j < height() ? -1 : 0;
    const Pose& pose =
        poses_[poses_.size() == 1 ? 0 : static_cast<std::size_t>(IndexInPixel(i, j))];
    const float x = static_cast<float>((i + 0.5) / n_ - camera_.cx) * inv_fx;
    const float y = static_cast<float>((j + 0.5) / n_ - camera_.cy) * inv_fy;
    const Eigen::Vector3f direction = pose.world_from_cam * Eigen::Vector3f(x, y, 1);
    RTCRay16& ray = rays->ray;
    ray.org_x[lane] = pose.center.x();
    ray.org_y[lane] = pose.center.y();
    ray.org_z[lane] = pose.center.z();
    ray.dir_x[lane] = direction.x();
    ray.dir_y[lane] = direction.y();
    ray.dir_z[lane] = direction.z();
    ray.tnear[lane] = 1e-3F;
    ray.tfar[lane] = std::numeric_limits<float>::infinity();
    ray.time[lane] = 0;
    ray.mask[lane] = ~0U;
    ray.id[lane] = 0;
    ray.flags[lane] = 0;
    rays->hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    rays->hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace colmap_ext
