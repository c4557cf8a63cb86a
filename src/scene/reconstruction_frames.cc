// rigs and frames of a model, binary and text. Layout: https://colmap.github.io/format.html
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/byte_reader.h"
#include "scene/reconstruction_files.h"
#include "scene/same_pose.h"
#include "scene/text_reader.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMinRigBytes = 4 + 4;
constexpr std::size_t kMinFrameBytes = 4 + 4 + 7 * 8 + 4;

// One way to ask for the next value of a binary or a text file.
class BinarySource {
 public:
  explicit BinarySource(const fs::path& path) : in_(path) {}

  // Number of records of at least `min_bytes`.
  bool NextRecord(std::size_t min_bytes) {
    if (!num_left_) num_left_ = in_.ReadCount(min_bytes, "the number of records");
    if (*num_left_ == 0) {
      in_.ExpectEnd();
      return false;
    }
    --*num_left_;
    return true;
  }
  std::uint32_t NextId(const char* what) { return in_.Read<std::uint32_t>(what); }
  std::uint64_t NextDataId(const char* what) { return in_.Read<std::uint64_t>(what); }
  double NextDouble(const char* what) { return in_.Read<double>(what); }
  bool NextFlag(const char* what) { return in_.Read<std::uint8_t>(what) != 0; }
  SensorType NextSensorType(const char* what) {
    const auto type = in_.Read<std::int32_t>(what);
    if (type != 0 && type != 1) Fail(std::string(what) + " is " + std::to_string(type));
    return static_cast<SensorType>(type);
  }
  void EndRecord() {}
  [[noreturn]] void Fail(const std::string& problem) const { in_.Fail(problem); }

 private:
  ByteReader in_;
  std::optional<std::size_t> num_left_;
};

class TextSource {
 public:
  explicit TextSource(const fs::path& path) : in_(path) {}

  bool NextRecord(std::size_t) { return in_.NextRecord(); }
  std::uint32_t NextId(const char* what) { return in_.Next<std::uint32_t>(what); }
  std::uint64_t NextDataId(const char* what) { return in_.Next<std::uint64_t>(what); }
  double NextDouble(const char* what) { return in_.Next<double>(what); }
  bool NextFlag(const char* what) { return in_.Next<std::uint32_t>(what) != 0; }
  SensorType NextSensorType(const char* what) {
    const auto word = in_.NextWord();
    if (word == "CAMERA") return SensorType::kCamera;
    if (word == "IMU") return SensorType::kImu;
    Fail(std::string(what) + " is neither CAMERA nor IMU");
  }
  void EndRecord() { in_.ExpectLineEnd(); }
  [[noreturn]] void Fail(const std::string& problem) const { in_.Fail(problem); }

 private:
  TextReader in_;
};

template <typename Source>
SensorId NextSensor(Source& in) {
  SensorId sensor;
  sensor.type = in.NextSensorType("a sensor's type");
  sensor.id = in.NextId("a sensor's id");
  return sensor;
}

template <typename Source>
Rigid3d NextPose(Source& in) {
  double q[4], t[3];
  for (double& value : q) value = in.NextDouble("a rotation");
  for (double& value : t) value = in.NextDouble("a translation");
  const Rigid3d pose{RotationFromFile(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
  if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
    in.Fail("a pose is no rotation and finite translation; the file is corrupt");
  }
  return pose;
}

template <typename Source>
std::map<RigId, Rig> ReadRigs(const fs::path& path) {
  Source in(path);
  std::map<RigId, Rig> rigs;
  while (in.NextRecord(kMinRigBytes)) {
    const RigId id = in.NextId("a rig's id");
    const std::uint32_t num_sensors = in.NextId("a rig's number of sensors");
    const std::string name = "rig " + std::to_string(id);
    if (num_sensors == 0) in.Fail(name + " has no sensor; the file is corrupt");
    Rig rig;
    rig.reference = NextSensor(in);
    for (std::uint32_t i = 1; i < num_sensors; ++i) {
      const SensorId sensor = NextSensor(in);
      std::optional<Rigid3d> pose;
      if (in.NextFlag("a sensor's HAS_POSE")) pose = NextPose(in);
      if (!rig.sensor_from_rig.emplace(sensor, pose).second) {
        in.Fail(name + " has a sensor twice; the file is corrupt");
      }
    }
    in.EndRecord();
    if (!rigs.emplace(id, std::move(rig)).second) in.Fail(name + " is there twice");
  }
  return rigs;
}

struct PosedFrames {
  std::map<FrameId, Frame> frames;
  std::map<FrameId, Rigid3d> rig_from_world;
};

template <typename Source>
PosedFrames ReadFrames(const fs::path& path) {
  Source in(path);
  PosedFrames result;
  while (in.NextRecord(kMinFrameBytes)) {
    const FrameId id = in.NextId("a frame's id");
    Frame frame;
    frame.rig_id = in.NextId("a frame's rig");
    result.rig_from_world[id] = NextPose(in);
    const std::uint32_t num_data = in.NextId("a frame's number of data");
    for (std::uint32_t i = 0; i < num_data; ++i) {
      const SensorId sensor = NextSensor(in);
      frame.data.push_back({sensor, in.NextDataId("a frame's data id")});
    }
    in.EndRecord();
    if (!result.frames.emplace(id, std::move(frame)).second) {
      in.Fail("frame " + std::to_string(id) + " is there twice; the file is corrupt");
    }
  }
  return result;
}

// COLMAP takes the poses from the frames, we take them from the photos: both must say the same.
void RequireSamePoses(const Reconstruction& model, const PosedFrames& posed, const fs::path& path) {
  const FrameTable table = FrameTableOf(model);
  for (const auto& [id, frame] : table.frames) {
    const auto found = posed.rig_from_world.find(id);
    if (found == posed.rig_from_world.end()) continue;
    const Rigid3d pose = RigFromWorld(model, table, id);
    if (AreSamePoses(pose, found->second)) continue;
    throw Error(path.string() + ": frame " + std::to_string(id) +
                " has another pose than its photos have; remove rigs and frames from the folder "
                "to use the poses of the photos");
  }
}

template <typename Source>
void ReadTable(const fs::path& rigs_path, const fs::path& frames_path, Reconstruction* model) {
  if (!fs::exists(rigs_path) && !fs::exists(frames_path)) return;
  model->frame_table.rigs = ReadRigs<Source>(rigs_path);
  PosedFrames posed = ReadFrames<Source>(frames_path);
  model->frame_table.frames = std::move(posed.frames);
  CheckConsistency(*model, frames_path.parent_path().string());
  RequireSamePoses(*model, posed, frames_path);
}

// ---- Writing. The table is that of FrameTableOf.

void WriteSensor(const SensorId& sensor, std::ostream& out) {
  WriteBytes<std::int32_t>(out, static_cast<std::int32_t>(sensor.type));
  WriteBytes<std::uint32_t>(out, sensor.id);
}

void WritePose(const Rigid3d& pose, std::ostream& out) {
  const Eigen::Quaterniond& q = pose.rotation;
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) WriteBytes<double>(out, value);
  for (const double value : pose.translation) WriteBytes<double>(out, value);
}

void WriteRigs(const std::map<RigId, Rig>& rigs, std::ostream& out) {
  WriteBytes<std::uint64_t>(out, rigs.size());
  for (const auto& [id, rig] : rigs) {
    WriteBytes<RigId>(out, id);
    WriteBytes<std::uint32_t>(out, static_cast<std::uint32_t>(1 + rig.sensor_from_rig.size()));
    WriteSensor(rig.reference, out);
    for (const auto& [sensor, pose] : rig.sensor_from_rig) {
      WriteSensor(sensor, out);
      WriteBytes<std::uint8_t>(out, pose ? 1 : 0);
      if (pose) WritePose(*pose, out);
    }
  }
}

void WriteFrames(const Reconstruction& model, const FrameTable& table, std::ostream& out) {
  WriteBytes<std::uint64_t>(out, table.frames.size());
  for (const auto& [id, frame] : table.frames) {
    WriteBytes<FrameId>(out, id);
    WriteBytes<RigId>(out, frame.rig_id);
    WritePose(RigFromWorld(model, table, id), out);
    WriteBytes<std::uint32_t>(out, static_cast<std::uint32_t>(frame.data.size()));
    for (const FrameData& data : frame.data) {
      WriteSensor(data.sensor, out);
      WriteBytes<std::uint64_t>(out, data.id);
    }
  }
}

std::string TextOf(const SensorId& sensor) {
  return (sensor.type == SensorType::kCamera ? " CAMERA " : " IMU ") + std::to_string(sensor.id);
}

void WritePoseText(const Rigid3d& pose, std::ostream& out) {
  const Eigen::Quaterniond& q = pose.rotation;
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) out << ' ' << Digits{value};
  for (const double value : pose.translation) out << ' ' << Digits{value};
}

void WriteRigsText(const std::map<RigId, Rig>& rigs, std::ostream& out) {
  out << "# Rig calib list with one line of data per calib:\n"
         "#   RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as (SENSOR_TYPE, "
         "SENSOR_ID, HAS_POSE, [QW, QX, QY, QZ, TX, TY, TZ])\n"
         "# Number of rigs: "
      << rigs.size() << '\n';
  for (const auto& [id, rig] : rigs) {
    out << id << ' ' << 1 + rig.sensor_from_rig.size() << TextOf(rig.reference);
    for (const auto& [sensor, pose] : rig.sensor_from_rig) {
      out << TextOf(sensor) << (pose ? " 1" : " 0");
      if (pose) WritePoseText(*pose, out);
    }
    out << '\n';
  }
}

void WriteFramesText(const Reconstruction& model, const FrameTable& table, std::ostream& out) {
  out << "# Frame list with one line of data per frame:\n"
         "#   FRAME_ID, RIG_ID, RIG_FROM_WORLD[QW, QX, QY, QZ, TX, TY, TZ], NUM_DATA_IDS, "
         "DATA_IDS[] as (SENSOR_TYPE, SENSOR_ID, DATA_ID)\n"
         "# Number of frames: "
      << table.frames.size() << '\n';
  for (const auto& [id, frame] : table.frames) {
    out << id << ' ' << frame.rig_id;
    WritePoseText(RigFromWorld(model, table, id), out);
    out << ' ' << frame.data.size();
    for (const FrameData& data : frame.data) out << TextOf(data.sensor) << ' ' << data.id;
    out << '\n';
  }
}

}  // namespace

void ReadBinaryFrameTable(const fs::path& folder, Reconstruction* model) {
  ReadTable<BinarySource>(folder / "rigs.bin", folder / "frames.bin", model);
}

void ReadTextFrameTable(const fs::path& folder, Reconstruction* model) {
  ReadTable<TextSource>(folder / "rigs.txt", folder / "frames.txt", model);
}

// The frames first: when a pose does not fit its rig, nothing is written.
void WriteBinaryFrameTable(const Reconstruction& model, const fs::path& folder) {
  const FrameTable table = FrameTableOf(model);
  WriteFileAtomically(folder / "frames.bin",
                      [&](std::ostream& out) { WriteFrames(model, table, out); });
  WriteFileAtomically(folder / "rigs.bin", [&](std::ostream& out) { WriteRigs(table.rigs, out); });
}

void WriteTextFrameTable(const Reconstruction& model, const fs::path& folder) {
  const FrameTable table = FrameTableOf(model);
  WriteFileAtomically(folder / "frames.txt",
                      [&](std::ostream& out) { WriteFramesText(model, table, out); });
  WriteFileAtomically(folder / "rigs.txt",
                      [&](std::ostream& out) { WriteRigsText(table.rigs, out); });
}

}  // namespace colmap_ext
