#include "colmap_ext/scene/rig.h"

#include <cmath>
#include <set>

#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/error.h"
#include "scene/same_pose.h"

namespace colmap_ext {
namespace {

std::string NameOf(const SensorId& sensor) {
  return (sensor.type == SensorType::kCamera ? "camera " : "sensor ") + std::to_string(sensor.id);
}

bool HasSensor(const Rig& rig, const SensorId& sensor) {
  return rig.reference == sensor || rig.sensor_from_rig.contains(sensor);
}

// `wanted` when the map does not have it, else the one behind the largest.
template <typename Id, typename Value>
Id FreeId(const std::map<Id, Value>& taken, Id wanted) {
  return taken.contains(wanted) ? taken.rbegin()->first + 1 : wanted;
}

std::optional<RigId> RigWithCamera(const FrameTable& table, CameraId camera_id) {
  for (const auto& [id, rig] : table.rigs) {
    if (HasSensor(rig, {SensorType::kCamera, camera_id})) return id;
  }
  return std::nullopt;
}

void AddFrameOf(ImageId image_id, CameraId camera_id, FrameTable* table) {
  const SensorId camera{SensorType::kCamera, camera_id};
  std::optional<RigId> rig_id = RigWithCamera(*table, camera_id);
  if (!rig_id) {
    rig_id = FreeId(table->rigs, camera_id);
    table->rigs[*rig_id].reference = camera;
  }
  table->frames[FreeId(table->frames, image_id)] = {*rig_id, {{camera, image_id}}};
}

// Where the rig has this sensor; nullopt when that is not known.
std::optional<Rigid3d> SensorFromRig(const Rig& rig, const SensorId& sensor) {
  if (rig.reference == sensor) return Rigid3d();
  const auto found = rig.sensor_from_rig.find(sensor);
  return found == rig.sensor_from_rig.end() ? std::nullopt : found->second;
}

}  // namespace

std::string ProblemOf(const FrameTable& table) {
  std::set<SensorId> sensors;
  for (const auto& [id, rig] : table.rigs) {
    std::set<SensorId> own = {rig.reference};
    for (const auto& [sensor, pose] : rig.sensor_from_rig) {
      if (!own.insert(sensor).second) {
        return "rig " + std::to_string(id) + " has " + NameOf(sensor) + " twice";
      }
    }
    for (const SensorId& sensor : own) {
      if (!sensors.insert(sensor).second) return NameOf(sensor) + " is in two rigs";
    }
  }
  std::set<std::uint64_t> photos;
  for (const auto& [id, frame] : table.frames) {
    const std::string name = "frame " + std::to_string(id);
    const auto rig = table.rigs.find(frame.rig_id);
    if (rig == table.rigs.end()) {
      return name + " is of rig " + std::to_string(frame.rig_id) + ", which does not exist";
    }
    for (const FrameData& data : frame.data) {
      if (!HasSensor(rig->second, data.sensor)) {
        return name + " has data of " + NameOf(data.sensor) + ", which is not in its rig";
      }
      if (data.sensor.type == SensorType::kCamera && !photos.insert(data.id).second) {
        return "photo " + std::to_string(data.id) + " is in two frames";
      }
    }
  }
  return "";
}

FrameTable FrameTableOf(const Reconstruction& model) {
  FrameTable table;
  table.rigs = model.frame_table.rigs;
  std::set<std::uint64_t> placed;
  for (const auto& [id, frame] : model.frame_table.frames) {
    Frame kept{frame.rig_id, {}};
    bool has_photo = false;
    for (const FrameData& data : frame.data) {
      const bool is_photo = data.sensor.type == SensorType::kCamera;
      if (is_photo && !model.images.contains(static_cast<ImageId>(data.id))) continue;
      if (is_photo) placed.insert(data.id);
      has_photo = has_photo || is_photo;
      kept.data.push_back(data);
    }
    if (has_photo) table.frames[id] = std::move(kept);
  }
  for (const auto& [id, image] : model.images) {
    if (!placed.contains(id)) AddFrameOf(id, image.camera_id, &table);
  }
  return table;
}

Rigid3d RigFromWorld(const Reconstruction& model, const FrameTable& table, FrameId frame_id) {
  const Frame& frame = table.frames.at(frame_id);
  const Rig& rig = table.rigs.at(frame.rig_id);
  std::optional<Rigid3d> rig_from_world;
  for (const FrameData& data : frame.data) {
    if (data.sensor.type != SensorType::kCamera) continue;
    const std::optional<Rigid3d> sensor_from_rig = SensorFromRig(rig, data.sensor);
    if (!sensor_from_rig) continue;
    const SparseImage& image = model.images.at(static_cast<ImageId>(data.id));
    const Rigid3d pose = Inverse(*sensor_from_rig) * image.cam_from_world;
    if (rig_from_world && !AreSamePoses(*rig_from_world, pose)) {
      throw Error("frame " + std::to_string(frame_id) + ": the pose of photo '" + image.name +
                  "' is not where rig " + std::to_string(frame.rig_id) +
                  " has its camera; adjust rigs of several cameras with COLMAP itself");
    }
    // The reference sensor's photo is exact, without rounding by the rig.
    if (!rig_from_world || data.sensor == rig.reference) rig_from_world = pose;
  }
  if (!rig_from_world) {
    throw Error("frame " + std::to_string(frame_id) + ": no photo of it has a known place in rig " +
                std::to_string(frame.rig_id) + "; calibrate the rig with COLMAP first");
  }
  return *rig_from_world;
}

}  // namespace colmap_ext
