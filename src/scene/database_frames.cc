// The tables rigs, rig_sensors, frames and frame_data of COLMAP 3.12 and later.
#include <cstring>
#include <limits>

#include "scene/database_impl.h"

namespace colmap_ext {
namespace {

constexpr std::int64_t kMaxId = std::numeric_limits<std::uint32_t>::max();

// SQL columns type, id.
SensorId SensorFrom(const SqliteStatement& statement, int column) {
  const auto type = static_cast<SensorType>(statement.Integer(column, 0, 1));
  return {type, static_cast<std::uint32_t>(statement.Integer(column + 1, 0, kMaxId))};
}

// Seven doubles: rotation w, x, y, z, then the translation; NULL: not known.
std::optional<Rigid3d> PoseFrom(const SqliteStatement& statement, int column) {
  const auto blob = statement.Blob(column);
  if (blob.empty()) return std::nullopt;
  double values[7] = {};
  if (blob.size() != sizeof(values)) {
    statement.FailWith("a sensor's place in its rig has " + std::to_string(blob.size()) +
                       " bytes, not 56; the database is corrupt");
  }
  std::memcpy(values, blob.data(), sizeof(values));
  const Eigen::Quaterniond q(values[0], values[1], values[2], values[3]);
  const Rigid3d pose{q.normalized(), {values[4], values[5], values[6]}};
  if (!(q.norm() > 0.5) || !pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
    statement.FailWith(
        "a sensor's place in its rig is no rotation and finite translation; the database is "
        "corrupt");
  }
  return pose;
}

template <typename Id>
Id IdFrom(const SqliteStatement& statement, int column) {
  return static_cast<Id>(statement.Integer(column, 0, kMaxId));
}

}  // namespace

FrameTable ReadFrameTableRows(const SqliteConnection& connection) {
  FrameTable table;
  SqliteStatement rigs(connection, "SELECT rig_id, ref_sensor_type, ref_sensor_id FROM rigs",
                       "read the rigs");
  while (rigs.Step()) table.rigs[IdFrom<RigId>(rigs, 0)].reference = SensorFrom(rigs, 1);

  SqliteStatement sensors(connection,
                          "SELECT rig_id, sensor_type, sensor_id, sensor_from_rig "
                          "FROM rig_sensors",
                          "read the sensors of the rigs");
  while (sensors.Step()) {
    const auto rig = table.rigs.find(IdFrom<RigId>(sensors, 0));
    if (rig == table.rigs.end()) {
      connection.FailWith("has a sensor of a rig that does not exist; the database is corrupt");
    }
    rig->second.sensor_from_rig[SensorFrom(sensors, 1)] = PoseFrom(sensors, 3);
  }

  SqliteStatement frames(connection, "SELECT frame_id, rig_id FROM frames", "read the frames");
  while (frames.Step()) table.frames[IdFrom<FrameId>(frames, 0)].rig_id = IdFrom<RigId>(frames, 1);

  SqliteStatement data(connection,
                       "SELECT frame_id, sensor_type, sensor_id, data_id FROM frame_data "
                       "ORDER BY frame_id, sensor_type, sensor_id, data_id",
                       "read what the frames hold");
  while (data.Step()) {
    const auto frame = table.frames.find(IdFrom<FrameId>(data, 0));
    if (frame == table.frames.end()) {
      connection.FailWith("has data of a frame that does not exist; the database is corrupt");
    }
    const auto id = static_cast<std::uint64_t>(data.Integer(3, 0, kMaxId));
    frame->second.data.push_back({SensorFrom(data, 1), id});
  }
  return table;
}

}  // namespace colmap_ext
