// COLMAP's sparse model: what cameras.bin, images.bin and points3D.bin hold, and rigs.bin and
// frames.bin of the versions that have them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/rig.h"

namespace colmap_ext {

using Point3DId = std::uint64_t;
inline constexpr Point3DId kInvalidPoint3DId = std::numeric_limits<Point3DId>::max();

struct Keypoint2D {
  Eigen::Vector2d pixel;  // COLMAP's pixel convention
  Point3DId point3D_id = kInvalidPoint3DId;
};

// A registered photo.
struct SparseImage {
  std::string name;  // relative to the image folder
  CameraId camera_id = 0;
  Rigid3d cam_from_world;
  std::vector<Keypoint2D> keypoints;
};

struct TrackElement {
  ImageId image_id = 0;
  std::uint32_t keypoint_index = 0;
};

struct SparsePoint {
  Eigen::Vector3d position;                                                             // world
  Eigen::Matrix<std::uint8_t, 3, 1> color = Eigen::Matrix<std::uint8_t, 3, 1>::Zero();  // RGB
  double error_px = -1;  // mean reprojection error; -1 unknown
  std::vector<TrackElement> track;
};

// Ordered maps, so that walking over a model has one order on every machine.
struct Reconstruction {
  std::map<CameraId, Camera> cameras;
  std::map<ImageId, SparseImage> images;
  std::map<Point3DId, SparsePoint> points;
  // Of models that have rigs: kept, so that they go back to a COLMAP that needs them. It need not
  // have every photo (see FrameTableOf).
  FrameTable frame_table = {};
};

// Throws Error naming what is inconsistent: a missing camera, a track element or keypoint that
// points to nothing, a non-finite pose, a wrong number of parameters, a frame without its rig.
void CheckConsistency(const Reconstruction& reconstruction, const std::string& where);

// Moves the whole model: points and camera centres by `new_from_old`; rigs grow with it.
void TransformReconstruction(const Sim3d& new_from_old, Reconstruction* reconstruction);

}  // namespace colmap_ext
