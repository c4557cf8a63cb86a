// Messages about how the vehicle is: battery, fence, estimator, wind, the pilot's sticks. Field
// names, units and meanings are MAVLink's own (mavlink.io, common.xml and ardupilotmega.xml).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "colmap_ext/mavlink/enums.h"
#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

// What the pilot's sticks say.
struct MavRcChannels {
  static constexpr std::uint32_t kId = 65;
  static constexpr std::string_view kName = "RC_CHANNELS";
  std::uint32_t time_boot_ms = 0;  // ms
  std::uint8_t chancount = 0;
  std::uint16_t chan1_raw = 0;   // us
  std::uint16_t chan2_raw = 0;   // us
  std::uint16_t chan3_raw = 0;   // us
  std::uint16_t chan4_raw = 0;   // us
  std::uint16_t chan5_raw = 0;   // us
  std::uint16_t chan6_raw = 0;   // us
  std::uint16_t chan7_raw = 0;   // us
  std::uint16_t chan8_raw = 0;   // us
  std::uint16_t chan9_raw = 0;   // us
  std::uint16_t chan10_raw = 0;  // us
  std::uint16_t chan11_raw = 0;  // us
  std::uint16_t chan12_raw = 0;  // us
  std::uint16_t chan13_raw = 0;  // us
  std::uint16_t chan14_raw = 0;  // us
  std::uint16_t chan15_raw = 0;  // us
  std::uint16_t chan16_raw = 0;  // us
  std::uint16_t chan17_raw = 0;  // us
  std::uint16_t chan18_raw = 0;  // us
  std::uint8_t rssi = 0;
  static constexpr auto Fields() {
    using M = MavRcChannels;
    return std::tuple(
        MavField("time_boot_ms", &M::time_boot_ms), MavField("chancount", &M::chancount),
        MavField("chan1_raw", &M::chan1_raw), MavField("chan2_raw", &M::chan2_raw),
        MavField("chan3_raw", &M::chan3_raw), MavField("chan4_raw", &M::chan4_raw),
        MavField("chan5_raw", &M::chan5_raw), MavField("chan6_raw", &M::chan6_raw),
        MavField("chan7_raw", &M::chan7_raw), MavField("chan8_raw", &M::chan8_raw),
        MavField("chan9_raw", &M::chan9_raw), MavField("chan10_raw", &M::chan10_raw),
        MavField("chan11_raw", &M::chan11_raw), MavField("chan12_raw", &M::chan12_raw),
        MavField("chan13_raw", &M::chan13_raw), MavField("chan14_raw", &M::chan14_raw),
        MavField("chan15_raw", &M::chan15_raw), MavField("chan16_raw", &M::chan16_raw),
        MavField("chan17_raw", &M::chan17_raw), MavField("chan18_raw", &M::chan18_raw),
        MavField("rssi", &M::rssi));
  }
  bool operator==(const MavRcChannels&) const = default;
};

// One battery. Cells that are not there have UINT16_MAX.
struct MavBatteryStatus {
  static constexpr std::uint32_t kId = 147;
  static constexpr std::string_view kName = "BATTERY_STATUS";
  std::uint8_t id = 0;
  std::uint8_t battery_function = 0;
  std::uint8_t type = 0;
  std::int16_t temperature = 0;              // cdegC
  std::array<std::uint16_t, 10> voltages{};  // mV
  std::int16_t current_battery = 0;          // cA
  std::int32_t current_consumed = 0;         // mAh
  std::int32_t energy_consumed = 0;          // hJ
  std::int8_t battery_remaining = 0;         // %
  // Extensions.
  std::int32_t time_remaining = 0;  // s
  MavBatteryChargeState charge_state{};
  std::array<std::uint16_t, 4> voltages_ext{};  // mV
  std::uint8_t mode = 0;
  std::uint32_t fault_bitmask = 0;
  static constexpr auto Fields() {
    using M = MavBatteryStatus;
    return std::tuple(
        MavField("id", &M::id), MavField("battery_function", &M::battery_function),
        MavField("type", &M::type), MavField("temperature", &M::temperature),
        MavField("voltages", &M::voltages), MavField("current_battery", &M::current_battery),
        MavField("current_consumed", &M::current_consumed),
        MavField("energy_consumed", &M::energy_consumed),
        MavField("battery_remaining", &M::battery_remaining),
        MavExtension("time_remaining", &M::time_remaining),
        MavExtension("charge_state", &M::charge_state),
        MavExtension("voltages_ext", &M::voltages_ext), MavExtension("mode", &M::mode),
        MavExtension("fault_bitmask", &M::fault_bitmask));
  }
  bool operator==(const MavBatteryStatus&) const = default;
};

// Whether a fence is breached.
struct MavFenceStatus {
  static constexpr std::uint32_t kId = 162;
  static constexpr std::string_view kName = "FENCE_STATUS";
  std::uint8_t breach_status = 0;
  std::uint16_t breach_count = 0;
  MavFenceBreach breach_type{};
  std::uint32_t breach_time = 0;  // ms
  // Extensions.
  std::uint8_t breach_mitigation = 0;
  static constexpr auto Fields() {
    using M = MavFenceStatus;
    return std::tuple(
        MavField("breach_status", &M::breach_status), MavField("breach_count", &M::breach_count),
        MavField("breach_type", &M::breach_type), MavField("breach_time", &M::breach_time),
        MavExtension("breach_mitigation", &M::breach_mitigation));
  }
  bool operator==(const MavFenceStatus&) const = default;
};

// Wind, as ArduPilot says it.
struct MavWind {
  static constexpr std::uint32_t kId = 168;
  static constexpr std::string_view kName = "WIND";
  float direction = 0;  // deg
  float speed = 0;      // m/s
  float speed_z = 0;    // m/s
  static constexpr auto Fields() {
    using M = MavWind;
    return std::tuple(MavField("direction", &M::direction), MavField("speed", &M::speed),
                      MavField("speed_z", &M::speed_z));
  }
  bool operator==(const MavWind&) const = default;
};

// Health of ArduPilot's estimator; see MavEkfFlag.
struct MavEkfStatusReport {
  static constexpr std::uint32_t kId = 193;
  static constexpr std::string_view kName = "EKF_STATUS_REPORT";
  std::uint16_t flags = 0;
  float velocity_variance = 0;
  float pos_horiz_variance = 0;
  float pos_vert_variance = 0;
  float compass_variance = 0;
  float terrain_alt_variance = 0;
  // Extensions.
  float airspeed_variance = 0;
  static constexpr auto Fields() {
    using M = MavEkfStatusReport;
    return std::tuple(MavField("flags", &M::flags),
                      MavField("velocity_variance", &M::velocity_variance),
                      MavField("pos_horiz_variance", &M::pos_horiz_variance),
                      MavField("pos_vert_variance", &M::pos_vert_variance),
                      MavField("compass_variance", &M::compass_variance),
                      MavField("terrain_alt_variance", &M::terrain_alt_variance),
                      MavExtension("airspeed_variance", &M::airspeed_variance));
  }
  bool operator==(const MavEkfStatusReport&) const = default;
};

// Health of PX4's estimator; see MavEstimatorFlag.
struct MavEstimatorStatus {
  static constexpr std::uint32_t kId = 230;
  static constexpr std::string_view kName = "ESTIMATOR_STATUS";
  std::uint64_t time_usec = 0;  // us
  std::uint16_t flags = 0;
  float vel_ratio = 0;
  float pos_horiz_ratio = 0;
  float pos_vert_ratio = 0;
  float mag_ratio = 0;
  float hagl_ratio = 0;
  float tas_ratio = 0;
  float pos_horiz_accuracy = 0;  // m
  float pos_vert_accuracy = 0;   // m
  static constexpr auto Fields() {
    using M = MavEstimatorStatus;
    return std::tuple(
        MavField("time_usec", &M::time_usec), MavField("flags", &M::flags),
        MavField("vel_ratio", &M::vel_ratio), MavField("pos_horiz_ratio", &M::pos_horiz_ratio),
        MavField("pos_vert_ratio", &M::pos_vert_ratio), MavField("mag_ratio", &M::mag_ratio),
        MavField("hagl_ratio", &M::hagl_ratio), MavField("tas_ratio", &M::tas_ratio),
        MavField("pos_horiz_accuracy", &M::pos_horiz_accuracy),
        MavField("pos_vert_accuracy", &M::pos_vert_accuracy));
  }
  bool operator==(const MavEstimatorStatus&) const = default;
};

// Wind, as PX4 says it.
struct MavWindCov {
  static constexpr std::uint32_t kId = 231;
  static constexpr std::string_view kName = "WIND_COV";
  std::uint64_t time_usec = 0;  // us
  float wind_x = 0;             // m/s
  float wind_y = 0;             // m/s
  float wind_z = 0;             // m/s
  float var_horiz = 0;          // m/s
  float var_vert = 0;           // m/s
  float wind_alt = 0;           // m
  float horiz_accuracy = 0;     // m/s
  float vert_accuracy = 0;      // m/s
  static constexpr auto Fields() {
    using M = MavWindCov;
    return std::tuple(MavField("time_usec", &M::time_usec), MavField("wind_x", &M::wind_x),
                      MavField("wind_y", &M::wind_y), MavField("wind_z", &M::wind_z),
                      MavField("var_horiz", &M::var_horiz), MavField("var_vert", &M::var_vert),
                      MavField("wind_alt", &M::wind_alt),
                      MavField("horiz_accuracy", &M::horiz_accuracy),
                      MavField("vert_accuracy", &M::vert_accuracy));
  }
  bool operator==(const MavWindCov&) const = default;
};

// In the air or on the ground.
struct MavExtendedSysState {
  static constexpr std::uint32_t kId = 245;
  static constexpr std::string_view kName = "EXTENDED_SYS_STATE";
  std::uint8_t vtol_state = 0;
  MavLandedState landed_state{};
  static constexpr auto Fields() {
    using M = MavExtendedSysState;
    return std::tuple(MavField("vtol_state", &M::vtol_state),
                      MavField("landed_state", &M::landed_state));
  }
  bool operator==(const MavExtendedSysState&) const = default;
};

}  // namespace colmap_ext
