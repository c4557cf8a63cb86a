// Rigs and frames: how COLMAP from 3.12 on groups photos. A rig is a set of sensors that are fixed
// to each other, a frame one exposure of a rig; the pose of a frame is that of its rig. A drone
// with one camera makes a rig of one sensor and a frame of one photo.
// https://colmap.github.io/rigs.html
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

using CameraId = std::uint32_t;
using ImageId = std::uint32_t;
using RigId = std::uint32_t;
using FrameId = std::uint32_t;

enum class SensorType : std::int32_t { kCamera = 0, kImu = 1 };

struct SensorId {
  SensorType type = SensorType::kCamera;
  std::uint32_t id = 0;  // of a camera: its CameraId
  auto operator<=>(const SensorId&) const = default;
};

struct Rig {
  SensorId reference;  // its frame is the rig's
  // The other sensors; absent where the pose in the rig is not known.
  std::map<SensorId, std::optional<Rigid3d>> sensor_from_rig;
};

// What one sensor took in a frame.
struct FrameData {
  SensorId sensor;
  std::uint64_t id = 0;  // of a camera: the ImageId
};

struct Frame {
  RigId rig_id = 0;
  std::vector<FrameData> data;
};

// Empty in models and databases of versions that have no rigs.
struct FrameTable {
  std::map<RigId, Rig> rigs;
  std::map<FrameId, Frame> frames;
  bool IsEmpty() const { return rigs.empty() && frames.empty(); }
};

struct Reconstruction;

// "" when the table is sound, else what is wrong: a frame without rig, a sensor that its rig does
// not have or that two rigs have, a photo in two frames.
std::string ProblemOf(const FrameTable& table);

// The table for exactly the photos of `model`: frames of other photos are left out, and photos that
// no frame has get a frame of their own, of the rig of their camera. New ids are those of the photo
// and of the camera, or behind the largest where they are taken: as Database::Transaction chooses
// them.
FrameTable FrameTableOf(const Reconstruction& model);

// Pose of a frame from those of its photos. Throws Error naming the frame when its photos do not
// keep the places that the rig gives them (adjusted one by one, for example), or when none of them
// has a known place.
Rigid3d RigFromWorld(const Reconstruction& model, const FrameTable& table, FrameId frame_id);

}  // namespace colmap_ext
