// The part of a model that one bundle adjustment touches, in flat arrays.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "colmap_ext/sfm/bundle_adjustment.h"

namespace colmap_ext {

// A photo: cam_from_world = [exp(turn) rotation_base | centre]. Ceres changes turn and centre, so
// that the turn stays small and no rotation is singular.
struct BundlePose {
  ImageId image_id = 0;
  std::size_t camera = 0;  // index
  bool is_free = false;
  const PhotoPrior* prior = nullptr;  // null: none
  Eigen::Quaterniond rotation_base = Eigen::Quaterniond::Identity();
  double turn_and_center[6] = {};
  // Derived from these by Refresh.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d turn_jacobian = Eigen::Matrix3d::Identity();

  Eigen::Map<const Eigen::Vector3d> center() const {
    return Eigen::Map<const Eigen::Vector3d>(turn_and_center + 3);
  }
  Rigid3d CamFromWorld() const;
  void SetCamFromWorld(const Rigid3d& cam_from_world);  // as the new base
  // rotation = exp(turn) base, and d(rotation v) = -[rotation v]x turn_jacobian d(turn).
  void Refresh();
};

struct BundleCamera {
  CameraId camera_id = 0;
  Camera camera;
  std::vector<int> free_params;  // indices into the parameters
  double free_values[kMaxCameraParams] = {};
  void Refresh();  // camera from free_values
};

struct BundlePoint {
  Point3DId id = 0;
  bool is_free = false;
  bool is_alive = true;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::size_t first_observation = 0, num_observations = 0;
};

struct BundleObservation {
  std::size_t pose = 0, point = 0;  // indices
  std::uint32_t keypoint_index = 0;
  bool is_alive = true;  // cleared by a filter
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// Ordered by id, observations by point and then as in the track: one order on every machine.
struct BundleState {
  std::vector<BundlePose> poses;
  std::vector<BundleCamera> cameras;
  std::vector<BundlePoint> points;
  std::vector<BundleObservation> observations;

  // In the camera; not in front of it where z <= 0.
  Eigen::Vector3d PointInCam(const BundleObservation& observation) const;
  // Length in pixels; infinity for a point that is not in front of the camera.
  double ErrorPx(const BundleObservation& observation) const;
};

// Throws Error for unknown ids, bad priors and degenerate cameras (see AdjustBundle). The state
// points into `selection`.
BundleState GatherBundle(const BundleSelection& selection, const BundleOptions& options,
                         const std::vector<CameraId>& locked_cameras, const Reconstruction& model);

struct FilterCounts {
  std::size_t observations = 0, points = 0;
};
// Clears is_alive of what fails the filters of `options`.
FilterCounts FilterBundle(const BundleOptions& options, BundleState* state);

// Writes poses, cameras, points and their errors, and drops what is not alive.
void ApplyBundle(const BundleState& state, Reconstruction* model);

}  // namespace colmap_ext
