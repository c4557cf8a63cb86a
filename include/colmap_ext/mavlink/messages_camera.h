// Camera and gimbal messages. Field names, units and
// meanings are MAVLink's own (mavlink.io, common.xml and ardupilotmega.xml).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "colmap_ext/mavlink/enums.h"
#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

// Where the mount points, as ArduPilot said before gimbal v2.
struct MavMountStatus {
  static constexpr std::uint32_t kId = 158;
  static constexpr std::string_view kName = "MOUNT_STATUS";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::int32_t pointing_a = 0;  // cdeg
  std::int32_t pointing_b = 0;  // cdeg
  std::int32_t pointing_c = 0;  // cdeg
  // Extensions.
  MavMountMode mount_mode{};
  static constexpr auto Fields() {
    using M = MavMountStatus;
    return std::tuple(
        MavField("target_system", &M::target_system),
        MavField("target_component", &M::target_component), MavField("pointing_a", &M::pointing_a),
        MavField("pointing_b", &M::pointing_b), MavField("pointing_c", &M::pointing_c),
        MavExtension("mount_mode", &M::mount_mode));
  }
  bool operator==(const MavMountStatus&) const = default;
};

// A picture was taken, as ArduPilot says it.
struct MavCameraFeedback {
  static constexpr std::uint32_t kId = 180;
  static constexpr std::string_view kName = "CAMERA_FEEDBACK";
  std::uint64_t time_usec = 0;  // us
  std::uint8_t target_system = 0;
  std::uint8_t cam_idx = 0;
  std::uint16_t img_idx = 0;
  std::int32_t lat = 0;  // degE7
  std::int32_t lng = 0;  // degE7
  float alt_msl = 0;     // m
  float alt_rel = 0;     // m
  float roll = 0;        // deg
  float pitch = 0;       // deg
  float yaw = 0;         // deg
  float foc_len = 0;     // mm
  std::uint8_t flags = 0;
  // Extensions.
  std::uint16_t completed_captures = 0;
  static constexpr auto Fields() {
    using M = MavCameraFeedback;
    return std::tuple(
        MavField("time_usec", &M::time_usec), MavField("target_system", &M::target_system),
        MavField("cam_idx", &M::cam_idx), MavField("img_idx", &M::img_idx),
        MavField("lat", &M::lat), MavField("lng", &M::lng), MavField("alt_msl", &M::alt_msl),
        MavField("alt_rel", &M::alt_rel), MavField("roll", &M::roll), MavField("pitch", &M::pitch),
        MavField("yaw", &M::yaw), MavField("foc_len", &M::foc_len), MavField("flags", &M::flags),
        MavExtension("completed_captures", &M::completed_captures));
  }
  bool operator==(const MavCameraFeedback&) const = default;
};

// Who the camera is.
struct MavCameraInformation {
  static constexpr std::uint32_t kId = 259;
  static constexpr std::string_view kName = "CAMERA_INFORMATION";
  std::uint32_t time_boot_ms = 0;  // ms
  std::array<std::uint8_t, 32> vendor_name{};
  std::array<std::uint8_t, 32> model_name{};
  std::uint32_t firmware_version = 0;
  float focal_length = 0;          // mm
  float sensor_size_h = 0;         // mm
  float sensor_size_v = 0;         // mm
  std::uint16_t resolution_h = 0;  // pix
  std::uint16_t resolution_v = 0;  // pix
  std::uint8_t lens_id = 0;
  std::uint32_t flags = 0;
  std::uint16_t cam_definition_version = 0;
  std::array<char, 140> cam_definition_uri{};
  // Extensions.
  std::uint8_t gimbal_device_id = 0;
  std::uint8_t camera_device_id = 0;
  static constexpr auto Fields() {
    using M = MavCameraInformation;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("vendor_name", &M::vendor_name),
        MavField("model_name", &M::model_name), MavField("firmware_version", &M::firmware_version),
        MavField("focal_length", &M::focal_length), MavField("sensor_size_h", &M::sensor_size_h),
        MavField("sensor_size_v", &M::sensor_size_v), MavField("resolution_h", &M::resolution_h),
        MavField("resolution_v", &M::resolution_v), MavField("lens_id", &M::lens_id),
        MavField("flags", &M::flags),
        MavField("cam_definition_version", &M::cam_definition_version),
        MavField("cam_definition_uri", &M::cam_definition_uri),
        MavExtension("gimbal_device_id", &M::gimbal_device_id),
        MavExtension("camera_device_id", &M::camera_device_id));
  }
  bool operator==(const MavCameraInformation&) const = default;
};

// Mode of the camera.
struct MavCameraSettings {
  static constexpr std::uint32_t kId = 260;
  static constexpr std::string_view kName = "CAMERA_SETTINGS";
  std::uint32_t time_boot_ms = 0;  // ms
  MavCameraMode mode_id{};
  // Extensions.
  float zoomLevel = 0;
  float focusLevel = 0;
  std::uint8_t camera_device_id = 0;
  static constexpr auto Fields() {
    using M = MavCameraSettings;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("mode_id", &M::mode_id),
                      MavExtension("zoomLevel", &M::zoomLevel),
                      MavExtension("focusLevel", &M::focusLevel),
                      MavExtension("camera_device_id", &M::camera_device_id));
  }
  bool operator==(const MavCameraSettings&) const = default;
};

// Room on the camera's storage.
struct MavStorageInformation {
  static constexpr std::uint32_t kId = 261;
  static constexpr std::string_view kName = "STORAGE_INFORMATION";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint8_t storage_id = 0;
  std::uint8_t storage_count = 0;
  MavStorageStatus status{};
  float total_capacity = 0;      // MiB
  float used_capacity = 0;       // MiB
  float available_capacity = 0;  // MiB
  float read_speed = 0;          // MiB/s
  float write_speed = 0;         // MiB/s
  // Extensions.
  std::uint8_t type = 0;
  std::array<char, 32> name{};
  std::uint8_t storage_usage = 0;
  static constexpr auto Fields() {
    using M = MavStorageInformation;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("storage_id", &M::storage_id),
        MavField("storage_count", &M::storage_count), MavField("status", &M::status),
        MavField("total_capacity", &M::total_capacity),
        MavField("used_capacity", &M::used_capacity),
        MavField("available_capacity", &M::available_capacity),
        MavField("read_speed", &M::read_speed), MavField("write_speed", &M::write_speed),
        MavExtension("type", &M::type), MavExtension("name", &M::name),
        MavExtension("storage_usage", &M::storage_usage));
  }
  bool operator==(const MavStorageInformation&) const = default;
};

// Whether the camera is busy, and how many pictures it has.
struct MavCameraCaptureStatus {
  static constexpr std::uint32_t kId = 262;
  static constexpr std::string_view kName = "CAMERA_CAPTURE_STATUS";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint8_t image_status = 0;
  std::uint8_t video_status = 0;
  float image_interval = 0;             // s
  std::uint32_t recording_time_ms = 0;  // ms
  float available_capacity = 0;         // MiB
  // Extensions.
  std::int32_t image_count = 0;
  std::uint8_t camera_device_id = 0;
  static constexpr auto Fields() {
    using M = MavCameraCaptureStatus;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("image_status", &M::image_status),
        MavField("video_status", &M::video_status), MavField("image_interval", &M::image_interval),
        MavField("recording_time_ms", &M::recording_time_ms),
        MavField("available_capacity", &M::available_capacity),
        MavExtension("image_count", &M::image_count),
        MavExtension("camera_device_id", &M::camera_device_id));
  }
  bool operator==(const MavCameraCaptureStatus&) const = default;
};

// A picture was taken. q is the camera's attitude, w first, forward-right-down to NED.
struct MavCameraImageCaptured {
  static constexpr std::uint32_t kId = 263;
  static constexpr std::string_view kName = "CAMERA_IMAGE_CAPTURED";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint64_t time_utc = 0;      // us
  std::uint8_t camera_id = 0;
  std::int32_t lat = 0;           // degE7
  std::int32_t lon = 0;           // degE7
  std::int32_t alt = 0;           // mm
  std::int32_t relative_alt = 0;  // mm
  std::array<float, 4> q{};
  std::int32_t image_index = 0;
  std::int8_t capture_result = 0;
  std::array<char, 205> file_url{};
  static constexpr auto Fields() {
    using M = MavCameraImageCaptured;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("time_utc", &M::time_utc),
        MavField("camera_id", &M::camera_id), MavField("lat", &M::lat), MavField("lon", &M::lon),
        MavField("alt", &M::alt), MavField("relative_alt", &M::relative_alt), MavField("q", &M::q),
        MavField("image_index", &M::image_index), MavField("capture_result", &M::capture_result),
        MavField("file_url", &M::file_url));
  }
  bool operator==(const MavCameraImageCaptured&) const = default;
};

// Where the mount points, as PX4 says without gimbal v2.
struct MavMountOrientation {
  static constexpr std::uint32_t kId = 265;
  static constexpr std::string_view kName = "MOUNT_ORIENTATION";
  std::uint32_t time_boot_ms = 0;  // ms
  float roll = 0;                  // deg
  float pitch = 0;                 // deg
  float yaw = 0;                   // deg
  // Extensions.
  float yaw_absolute = 0;  // deg
  static constexpr auto Fields() {
    using M = MavMountOrientation;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("roll", &M::roll),
                      MavField("pitch", &M::pitch), MavField("yaw", &M::yaw),
                      MavExtension("yaw_absolute", &M::yaw_absolute));
  }
  bool operator==(const MavMountOrientation&) const = default;
};

// Limits of a gimbal.
struct MavGimbalManagerInformation {
  static constexpr std::uint32_t kId = 280;
  static constexpr std::string_view kName = "GIMBAL_MANAGER_INFORMATION";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint32_t cap_flags = 0;
  std::uint8_t gimbal_device_id = 0;
  float roll_min = 0;   // rad
  float roll_max = 0;   // rad
  float pitch_min = 0;  // rad
  float pitch_max = 0;  // rad
  float yaw_min = 0;    // rad
  float yaw_max = 0;    // rad
  static constexpr auto Fields() {
    using M = MavGimbalManagerInformation;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms),
                      MavField("cap_flags", &M::cap_flags),
                      MavField("gimbal_device_id", &M::gimbal_device_id),
                      MavField("roll_min", &M::roll_min), MavField("roll_max", &M::roll_max),
                      MavField("pitch_min", &M::pitch_min), MavField("pitch_max", &M::pitch_max),
                      MavField("yaw_min", &M::yaw_min), MavField("yaw_max", &M::yaw_max));
  }
  bool operator==(const MavGimbalManagerInformation&) const = default;
};

// Who controls the gimbal.
struct MavGimbalManagerStatus {
  static constexpr std::uint32_t kId = 281;
  static constexpr std::string_view kName = "GIMBAL_MANAGER_STATUS";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint32_t flags = 0;
  std::uint8_t gimbal_device_id = 0;
  std::uint8_t primary_control_sysid = 0;
  std::uint8_t primary_control_compid = 0;
  std::uint8_t secondary_control_sysid = 0;
  std::uint8_t secondary_control_compid = 0;
  static constexpr auto Fields() {
    using M = MavGimbalManagerStatus;
    return std::tuple(MavField("time_boot_ms", &M::time_boot_ms), MavField("flags", &M::flags),
                      MavField("gimbal_device_id", &M::gimbal_device_id),
                      MavField("primary_control_sysid", &M::primary_control_sysid),
                      MavField("primary_control_compid", &M::primary_control_compid),
                      MavField("secondary_control_sysid", &M::secondary_control_sysid),
                      MavField("secondary_control_compid", &M::secondary_control_compid));
  }
  bool operator==(const MavGimbalManagerStatus&) const = default;
};

// Who the gimbal is.
struct MavGimbalDeviceInformation {
  static constexpr std::uint32_t kId = 283;
  static constexpr std::string_view kName = "GIMBAL_DEVICE_INFORMATION";
  std::uint32_t time_boot_ms = 0;  // ms
  std::array<char, 32> vendor_name{};
  std::array<char, 32> model_name{};
  std::array<char, 32> custom_name{};
  std::uint32_t firmware_version = 0;
  std::uint32_t hardware_version = 0;
  std::uint64_t uid = 0;
  std::uint16_t cap_flags = 0;
  std::uint16_t custom_cap_flags = 0;
  float roll_min = 0;   // rad
  float roll_max = 0;   // rad
  float pitch_min = 0;  // rad
  float pitch_max = 0;  // rad
  float yaw_min = 0;    // rad
  float yaw_max = 0;    // rad
  // Extensions.
  std::uint8_t gimbal_device_id = 0;
  static constexpr auto Fields() {
    using M = MavGimbalDeviceInformation;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("vendor_name", &M::vendor_name),
        MavField("model_name", &M::model_name), MavField("custom_name", &M::custom_name),
        MavField("firmware_version", &M::firmware_version),
        MavField("hardware_version", &M::hardware_version), MavField("uid", &M::uid),
        MavField("cap_flags", &M::cap_flags), MavField("custom_cap_flags", &M::custom_cap_flags),
        MavField("roll_min", &M::roll_min), MavField("roll_max", &M::roll_max),
        MavField("pitch_min", &M::pitch_min), MavField("pitch_max", &M::pitch_max),
        MavField("yaw_min", &M::yaw_min), MavField("yaw_max", &M::yaw_max),
        MavExtension("gimbal_device_id", &M::gimbal_device_id));
  }
  bool operator==(const MavGimbalDeviceInformation&) const = default;
};

// Where the gimbal points: q as 263; whether yaw is from north or from the nose is in flags.
struct MavGimbalDeviceAttitudeStatus {
  static constexpr std::uint32_t kId = 285;
  static constexpr std::string_view kName = "GIMBAL_DEVICE_ATTITUDE_STATUS";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint16_t flags = 0;
  std::array<float, 4> q{};
  float angular_velocity_x = 0;  // rad/s
  float angular_velocity_y = 0;  // rad/s
  float angular_velocity_z = 0;  // rad/s
  std::uint32_t failure_flags = 0;
  // Extensions.
  float delta_yaw = 0;           // rad
  float delta_yaw_velocity = 0;  // rad/s
  std::uint8_t gimbal_device_id = 0;
  static constexpr auto Fields() {
    using M = MavGimbalDeviceAttitudeStatus;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("time_boot_ms", &M::time_boot_ms), MavField("flags", &M::flags),
                      MavField("q", &M::q), MavField("angular_velocity_x", &M::angular_velocity_x),
                      MavField("angular_velocity_y", &M::angular_velocity_y),
                      MavField("angular_velocity_z", &M::angular_velocity_z),
                      MavField("failure_flags", &M::failure_flags),
                      MavExtension("delta_yaw", &M::delta_yaw),
                      MavExtension("delta_yaw_velocity", &M::delta_yaw_velocity),
                      MavExtension("gimbal_device_id", &M::gimbal_device_id));
  }
  bool operator==(const MavGimbalDeviceAttitudeStatus&) const = default;
};

// Aims the gimbal. NaN leaves an axis as it is.
struct MavGimbalManagerSetPitchyaw {
  static constexpr std::uint32_t kId = 287;
  static constexpr std::string_view kName = "GIMBAL_MANAGER_SET_PITCHYAW";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint32_t flags = 0;
  std::uint8_t gimbal_device_id = 0;
  float pitch = 0;       // rad
  float yaw = 0;         // rad
  float pitch_rate = 0;  // rad/s
  float yaw_rate = 0;    // rad/s
  static constexpr auto Fields() {
    using M = MavGimbalManagerSetPitchyaw;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("flags", &M::flags),
                      MavField("gimbal_device_id", &M::gimbal_device_id),
                      MavField("pitch", &M::pitch), MavField("yaw", &M::yaw),
                      MavField("pitch_rate", &M::pitch_rate), MavField("yaw_rate", &M::yaw_rate));
  }
  bool operator==(const MavGimbalManagerSetPitchyaw&) const = default;
};

}  // namespace colmap_ext
