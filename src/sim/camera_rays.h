// The rays of a camera's samples, in packets.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/sim/renderer.h"
#include "sim/ray_packets.h"

namespace colmap_ext {

// Samples lie on a grid of n x n a pixel: sample (i, j) of the whole picture is at pixel
// coordinates
// ((i + 0.5) / n, (j + 0.5) / n). Directions have z = 1 in the camera frame, so that the ray
// parameter is the depth.
class CameraRays {
 public:
  static constexpr int kBlock = 4;  // a packet is a block of 4 x 4 samples
  static_assert(kBlock * kBlock == PacketScene::kWidth);

  CameraRays(const PinholeCamera& camera, const Rigid3d& cam_from_world, int samples_per_axis,
             const CameraMotion& motion, double shutter_s);

  int samples_per_axis() const { return n_; }
  int width() const { return camera_.width * n_; }    // samples
  int height() const { return camera_.height * n_; }  // samples
  // World length that one sample spans at depth 1.
  float SampleSpacing() const { return static_cast<float>(1.0 / (camera_.fx * n_)); }
  // Which of a pixel's n² samples sample (i, j) is.
  int IndexInPixel(int i, int j) const { return (j % n_) * n_ + i % n_; }

  // The packet whose first sample is (i0, j0). Lanes outside the picture get valid = 0, others -1.
  void FillPacket(int i0, int j0, RTCRayHit16* rays, int* valid) const;

 private:
  struct Pose {
    Eigen::Matrix3f world_from_cam;
    Eigen::Vector3f center;
  };
  PinholeCamera camera_;
  int n_;
  std::vector<Pose> poses_;  // one a sample of a pixel, or one for all
};

}  // namespace colmap_ext
