// What a camera sees of a textured scene: ray casting (Embree) with sun, shadows and sky light.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct RenderOptions {
  int samples_per_pixel = 4;      // stratified on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
  double sun_azimuth_deg = 215;   // clockwise from north, where the sun stands; [-360, 360]
  double sun_elevation_deg = 42;  // above the horizon; [1, 90]
  double sun_strength = 1;        // [0, 10]; 0: overcast
  double sky_strength = 1;        // [0, 10]
  bool shadows = true;            // of the sun
  int ambient_rays = 48;          // a vertex, for sky light that recesses lose; 0: none, … 1024
  double exposure = 1;            // factor on the light; [0.01, 100]
  double sensor_noise_sigma = 0;  // of grey levels 0 … 255, Gaussian; [0, 50]
  double shutter_s = 0;           // time over which CameraMotion blurs; 0: none; [0, 1]

  std::string Check() const;
};
void BindOptions(OptionSet& set, RenderOptions* options);  // section "Renderer"

// How the camera moves while the shutter is open; the pose given to Render() is in the middle.
struct CameraMotion {
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();    // m/s
  Eigen::Vector3d angular_rate_in_cam = Eigen::Vector3d::Zero();  // rad/s
};

// Immutable after construction; all methods may be called from many threads, and give the same
// picture whatever the number of threads.
class Renderer {
 public:
  // Copies what it needs of `scene`. Throws UsageError for invalid options, Error for an
  // inconsistent scene (CheckScene).
  Renderer(const TexturedScene& scene, const RenderOptions& options);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // CV_8UC3 BGR of camera.width x camera.height. `noise_seed` matters only with sensor noise; blur
  // needs shutter_s > 0 and takes its time steps from the samples of a pixel (use 16 or more).
  cv::Mat Render(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                 std::uint64_t noise_seed = 0, const CameraMotion& motion = {}) const;

  // CV_32FC1: z in the camera frame (metres) at the pixel centres; 0 where there is only sky. The
  // surface hit is found in float32, its depth computed from the triangle's plane in double.
  cv::Mat RenderDepth(const PinholeCamera& camera, const Rigid3d& cam_from_world) const;

  // CV_32SC1: face index in scene.mesh at the pixel centres; -1 where there is only sky.
  cv::Mat RenderFaces(const PinholeCamera& camera, const Rigid3d& cam_from_world) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
