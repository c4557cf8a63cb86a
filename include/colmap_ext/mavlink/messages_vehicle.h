// Messages about where the vehicle is and where it goes. Field names, units and
// meanings are MAVLink's own (mavlink.io, common.xml and ardupilotmega.xml).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "colmap_ext/mavlink/enums.h"
#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

// What the GPS itself says.
struct MavGpsRawInt {
  static constexpr std::uint32_t kId = 24;
  static constexpr std::string_view kName = "GPS_RAW_INT";
  std::uint64_t time_usec = 0;  // us
  MavGpsFixType fix_type{};
  std::int32_t lat = 0;  // degE7
  std::int32_t lon = 0;  // degE7
  std::int32_t alt = 0;  // mm
  std::uint16_t eph = 0;
  std::uint16_t epv = 0;
  std::uint16_t vel = 0;  // cm/s
  std::uint16_t cog = 0;  // cdeg
  std::uint8_t satellites_visible = 0;
  // Extensions.
  std::int32_t alt_ellipsoid = 0;  // mm
  std::uint32_t h_acc = 0;         // mm
  std::uint32_t v_acc = 0;         // mm
  std::uint32_t vel_acc = 0;       // mm/s
  std::uint32_t hdg_acc = 0;       // degE5
  std::uint16_t yaw = 0;           // cdeg
  static constexpr auto Fields() {
    using M = MavGpsRawInt;
    return std::tuple(
        MavField("time_usec", &M::time_usec), MavField("fix_type", &M::fix_type),
        MavField("lat", &M::lat), MavField("lon", &M::lon), MavField("alt", &M::alt),
        MavField("eph", &M::eph), MavField("epv", &M::epv), MavField("vel", &M::vel),
        MavField("cog", &M::cog), MavField("satellites_visible", &M::satellites_visible),
        MavExtension("alt_ellipsoid", &M::alt_ellipsoid), MavExtension("h_acc", &M::h_acc),
        MavExtension("v_acc", &M::v_acc), MavExtension("vel_acc", &M::vel_acc),
        MavExtension("hdg_acc", &M::hdg_acc), MavExtension("yaw", &M::yaw));
  }
  bool operator==(const MavGpsRawInt&) const = default;
};

// Attitude.
struct MavAttitude {
  static constexpr std::uint32_t kId = 30;
  static constexpr std::string_view kName = "ATTITUDE";
  std::uint32_t time_boot_ms = 0;  // ms
  float roll = 0;                  // rad
  float pitch = 0;                 // rad
  float yaw = 0;                   // rad
  float rollspeed = 0;             // rad/s
  float pitchspeed = 0;            // rad/s
  float yawspeed = 0;              // rad/s
  static constexpr auto Fields() {
    using M = MavAttitude;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("roll", &M::roll),
                      MavField("pitch", &M::pitch), MavField("yaw", &M::yaw),
                      MavField("rollspeed", &M::rollspeed), MavField("pitchspeed", &M::pitchspeed),
                      MavField("yawspeed", &M::yawspeed));
  }
  bool operator==(const MavAttitude&) const = default;
};

// Attitude as quaternion, w first.
struct MavAttitudeQuaternion {
  static constexpr std::uint32_t kId = 31;
  static constexpr std::string_view kName = "ATTITUDE_QUATERNION";
  std::uint32_t time_boot_ms = 0;  // ms
  float q1 = 0;
  float q2 = 0;
  float q3 = 0;
  float q4 = 0;
  float rollspeed = 0;   // rad/s
  float pitchspeed = 0;  // rad/s
  float yawspeed = 0;    // rad/s
  // Extensions.
  std::array<float, 4> repr_offset_q{};
  static constexpr auto Fields() {
    using M = MavAttitudeQuaternion;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("q1", &M::q1),
                      MavField("q2", &M::q2), MavField("q3", &M::q3), MavField("q4", &M::q4),
                      MavField("rollspeed", &M::rollspeed), MavField("pitchspeed", &M::pitchspeed),
                      MavField("yawspeed", &M::yawspeed),
                      MavExtension("repr_offset_q", &M::repr_offset_q));
  }
  bool operator==(const MavAttitudeQuaternion&) const = default;
};

// Position relative to the estimator's origin.
struct MavLocalPositionNed {
  static constexpr std::uint32_t kId = 32;
  static constexpr std::string_view kName = "LOCAL_POSITION_NED";
  std::uint32_t time_boot_ms = 0;  // ms
  float x = 0;                     // m
  float y = 0;                     // m
  float z = 0;                     // m
  float vx = 0;                    // m/s
  float vy = 0;                    // m/s
  float vz = 0;                    // m/s
  static constexpr auto Fields() {
    using M = MavLocalPositionNed;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("x", &M::x),
                      MavField("y", &M::y), MavField("z", &M::z), MavField("vx", &M::vx),
                      MavField("vy", &M::vy), MavField("vz", &M::vz));
  }
  bool operator==(const MavLocalPositionNed&) const = default;
};

// Filtered position.
struct MavGlobalPositionInt {
  static constexpr std::uint32_t kId = 33;
  static constexpr std::string_view kName = "GLOBAL_POSITION_INT";
  std::uint32_t time_boot_ms = 0;  // ms
  std::int32_t lat = 0;            // degE7
  std::int32_t lon = 0;            // degE7
  std::int32_t alt = 0;            // mm
  std::int32_t relative_alt = 0;   // mm
  std::int16_t vx = 0;             // cm/s
  std::int16_t vy = 0;             // cm/s
  std::int16_t vz = 0;             // cm/s
  std::uint16_t hdg = 0;           // cdeg
  static constexpr auto Fields() {
    using M = MavGlobalPositionInt;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("lat", &M::lat),
                      MavField("lon", &M::lon), MavField("alt", &M::alt),
                      MavField("relative_alt", &M::relative_alt), MavField("vx", &M::vx),
                      MavField("vy", &M::vy), MavField("vz", &M::vz), MavField("hdg", &M::hdg));
  }
  bool operator==(const MavGlobalPositionInt&) const = default;
};

// Origin of the local frame.
struct MavGpsGlobalOrigin {
  static constexpr std::uint32_t kId = 49;
  static constexpr std::string_view kName = "GPS_GLOBAL_ORIGIN";
  std::int32_t latitude = 0;   // degE7
  std::int32_t longitude = 0;  // degE7
  std::int32_t altitude = 0;   // mm
  // Extensions.
  std::uint64_t time_usec = 0;  // us
  static constexpr auto Fields() {
    using M = MavGpsGlobalOrigin;
    return std::tuple(MavField("latitude", &M::latitude), MavField("longitude", &M::longitude),
                      MavField("altitude", &M::altitude), MavExtension("time_usec", &M::time_usec));
  }
  bool operator==(const MavGpsGlobalOrigin&) const = default;
};

// What a head-up display shows.
struct MavVfrHud {
  static constexpr std::uint32_t kId = 74;
  static constexpr std::string_view kName = "VFR_HUD";
  float airspeed = 0;          // m/s
  float groundspeed = 0;       // m/s
  std::int16_t heading = 0;    // deg
  std::uint16_t throttle = 0;  // %
  float alt = 0;               // m
  float climb = 0;             // m/s
  static constexpr auto Fields() {
    using M = MavVfrHud;
    return std::tuple(MavField("airspeed", &M::airspeed), MavField("groundspeed", &M::groundspeed),
                      MavField("heading", &M::heading), MavField("throttle", &M::throttle),
                      MavField("alt", &M::alt), MavField("climb", &M::climb));
  }
  bool operator==(const MavVfrHud&) const = default;
};

// Where to go, as a stream.
struct MavSetPositionTargetGlobalInt {
  static constexpr std::uint32_t kId = 86;
  static constexpr std::string_view kName = "SET_POSITION_TARGET_GLOBAL_INT";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  MavCoordinateFrame coordinate_frame{};
  std::uint16_t type_mask = 0;
  std::int32_t lat_int = 0;  // degE7
  std::int32_t lon_int = 0;  // degE7
  float alt = 0;             // m
  float vx = 0;              // m/s
  float vy = 0;              // m/s
  float vz = 0;              // m/s
  float afx = 0;             // m/s/s
  float afy = 0;             // m/s/s
  float afz = 0;             // m/s/s
  float yaw = 0;             // rad
  float yaw_rate = 0;        // rad/s
  static constexpr auto Fields() {
    using M = MavSetPositionTargetGlobalInt;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("target_system", &M::target_system),
        MavField("target_component", &M::target_component),
        MavField("coordinate_frame", &M::coordinate_frame), MavField("type_mask", &M::type_mask),
        MavField("lat_int", &M::lat_int), MavField("lon_int", &M::lon_int),
        MavField("alt", &M::alt), MavField("vx", &M::vx), MavField("vy", &M::vy),
        MavField("vz", &M::vz), MavField("afx", &M::afx), MavField("afy", &M::afy),
        MavField("afz", &M::afz), MavField("yaw", &M::yaw), MavField("yaw_rate", &M::yaw_rate));
  }
  bool operator==(const MavSetPositionTargetGlobalInt&) const = default;
};

// Where the vehicle says that it is going.
struct MavPositionTargetGlobalInt {
  static constexpr std::uint32_t kId = 87;
  static constexpr std::string_view kName = "POSITION_TARGET_GLOBAL_INT";
  std::uint32_t time_boot_ms = 0;  // ms
  MavCoordinateFrame coordinate_frame{};
  std::uint16_t type_mask = 0;
  std::int32_t lat_int = 0;  // degE7
  std::int32_t lon_int = 0;  // degE7
  float alt = 0;             // m
  float vx = 0;              // m/s
  float vy = 0;              // m/s
  float vz = 0;              // m/s
  float afx = 0;             // m/s/s
  float afy = 0;             // m/s/s
  float afz = 0;             // m/s/s
  float yaw = 0;             // rad
  float yaw_rate = 0;        // rad/s
  static constexpr auto Fields() {
    using M = MavPositionTargetGlobalInt;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms),
                      MavField("coordinate_frame", &M::coordinate_frame),
                      MavField("type_mask", &M::type_mask), MavField("lat_int", &M::lat_int),
                      MavField("lon_int", &M::lon_int), MavField("alt", &M::alt),
                      MavField("vx", &M::vx), MavField("vy", &M::vy), MavField("vz", &M::vz),
                      MavField("afx", &M::afx), MavField("afy", &M::afy), MavField("afz", &M::afz),
                      MavField("yaw", &M::yaw), MavField("yaw_rate", &M::yaw_rate));
  }
  bool operator==(const MavPositionTargetGlobalInt&) const = default;
};

// All the heights.
struct MavAltitude {
  static constexpr std::uint32_t kId = 141;
  static constexpr std::string_view kName = "ALTITUDE";
  std::uint64_t time_usec = 0;   // us
  float altitude_monotonic = 0;  // m
  float altitude_amsl = 0;       // m
  float altitude_local = 0;      // m
  float altitude_relative = 0;   // m
  float altitude_terrain = 0;    // m
  float bottom_clearance = 0;    // m
  static constexpr auto Fields() {
    using M = MavAltitude;
    return std::tuple(MavField("time_usec", &M::time_usec),
                      MavField("altitude_monotonic", &M::altitude_monotonic),
                      MavField("altitude_amsl", &M::altitude_amsl),
                      MavField("altitude_local", &M::altitude_local),
                      MavField("altitude_relative", &M::altitude_relative),
                      MavField("altitude_terrain", &M::altitude_terrain),
                      MavField("bottom_clearance", &M::bottom_clearance));
  }
  bool operator==(const MavAltitude&) const = default;
};

// Where home is.
struct MavHomePosition {
  static constexpr std::uint32_t kId = 242;
  static constexpr std::string_view kName = "HOME_POSITION";
  std::int32_t latitude = 0;   // degE7
  std::int32_t longitude = 0;  // degE7
  std::int32_t altitude = 0;   // mm
  float x = 0;                 // m
  float y = 0;                 // m
  float z = 0;                 // m
  std::array<float, 4> q{};
  float approach_x = 0;  // m
  float approach_y = 0;  // m
  float approach_z = 0;  // m
  // Extensions.
  std::uint64_t time_usec = 0;  // us
  static constexpr auto Fields() {
    using M = MavHomePosition;
    return std::tuple(
        MavField("latitude", &M::latitude), MavField("longitude", &M::longitude),
        MavField("altitude", &M::altitude), MavField("x", &M::x), MavField("y", &M::y),
        MavField("z", &M::z), MavField("q", &M::q), MavField("approach_x", &M::approach_x),
        MavField("approach_y", &M::approach_y), MavField("approach_z", &M::approach_z),
        MavExtension("time_usec", &M::time_usec));
  }
  bool operator==(const MavHomePosition&) const = default;
};

}  // namespace colmap_ext
