// Messages about the link, the vehicle's identity, parameters, texts and files. Field names, units
// and meanings are MAVLink's own (mavlink.io, common.xml and ardupilotmega.xml).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "colmap_ext/mavlink/enums.h"
#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

// The sender lives: what it is, and in which mode.
struct MavHeartbeat {
  static constexpr std::uint32_t kId = 0;
  static constexpr std::string_view kName = "HEARTBEAT";
  MavType type{};
  MavAutopilot autopilot{};
  std::uint8_t base_mode = 0;
  std::uint32_t custom_mode = 0;
  MavState system_status{};
  std::uint8_t mavlink_version = 0;  // 3: the version of common.xml
  static constexpr auto Fields() {
    using M = MavHeartbeat;
    return std::tuple(MavField("type", &M::type), MavField("autopilot", &M::autopilot),
                      MavField("base_mode", &M::base_mode),
                      MavField("custom_mode", &M::custom_mode),
                      MavField("system_status", &M::system_status),
                      MavField("mavlink_version", &M::mavlink_version));
  }
  bool operator==(const MavHeartbeat&) const = default;
};

// Which sensors and failsafes are present, on and healthy; battery.
struct MavSysStatus {
  static constexpr std::uint32_t kId = 1;
  static constexpr std::string_view kName = "SYS_STATUS";
  std::uint32_t onboard_control_sensors_present = 0;
  std::uint32_t onboard_control_sensors_enabled = 0;
  std::uint32_t onboard_control_sensors_health = 0;
  std::uint16_t load = 0;             // d%
  std::uint16_t voltage_battery = 0;  // mV
  std::int16_t current_battery = 0;   // cA
  std::int8_t battery_remaining = 0;  // %
  std::uint16_t drop_rate_comm = 0;   // c%
  std::uint16_t errors_comm = 0;
  std::uint16_t errors_count1 = 0;
  std::uint16_t errors_count2 = 0;
  std::uint16_t errors_count3 = 0;
  std::uint16_t errors_count4 = 0;
  // Extensions.
  std::uint32_t onboard_control_sensors_present_extended = 0;
  std::uint32_t onboard_control_sensors_enabled_extended = 0;
  std::uint32_t onboard_control_sensors_health_extended = 0;
  static constexpr auto Fields() {
    using M = MavSysStatus;
    return std::tuple(
        MavField("onboard_control_sensors_present", &M::onboard_control_sensors_present),
        MavField("onboard_control_sensors_enabled", &M::onboard_control_sensors_enabled),
        MavField("onboard_control_sensors_health", &M::onboard_control_sensors_health),
        MavField("load", &M::load), MavField("voltage_battery", &M::voltage_battery),
        MavField("current_battery", &M::current_battery),
        MavField("battery_remaining", &M::battery_remaining),
        MavField("drop_rate_comm", &M::drop_rate_comm), MavField("errors_comm", &M::errors_comm),
        MavField("errors_count1", &M::errors_count1), MavField("errors_count2", &M::errors_count2),
        MavField("errors_count3", &M::errors_count3), MavField("errors_count4", &M::errors_count4),
        MavExtension("onboard_control_sensors_present_extended",
                     &M::onboard_control_sensors_present_extended),
        MavExtension("onboard_control_sensors_enabled_extended",
                     &M::onboard_control_sensors_enabled_extended),
        MavExtension("onboard_control_sensors_health_extended",
                     &M::onboard_control_sensors_health_extended));
  }
  bool operator==(const MavSysStatus&) const = default;
};

// Clock of the sender.
struct MavSystemTime {
  static constexpr std::uint32_t kId = 2;
  static constexpr std::string_view kName = "SYSTEM_TIME";
  std::uint64_t time_unix_usec = 0;  // us
  std::uint32_t time_boot_ms = 0;    // ms
  static constexpr auto Fields() {
    using M = MavSystemTime;
    return std::tuple(MavField("time_unix_usec", &M::time_unix_usec),
                      MavField("time_boot_ms", &M::time_boot_ms));
  }
  bool operator==(const MavSystemTime&) const = default;
};

// Round trip: a request has target 0/0, the answer names who asked.
struct MavPing {
  static constexpr std::uint32_t kId = 4;
  static constexpr std::string_view kName = "PING";
  std::uint64_t time_usec = 0;  // us
  std::uint32_t seq = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  static constexpr auto Fields() {
    using M = MavPing;
    return std::tuple(MavField("time_usec", &M::time_usec), MavField("seq", &M::seq),
                      MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component));
  }
  bool operator==(const MavPing&) const = default;
};

// Asks for one parameter, by name (param_index -1) or by index.
struct MavParamRequestRead {
  static constexpr std::uint32_t kId = 20;
  static constexpr std::string_view kName = "PARAM_REQUEST_READ";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<char, 16> param_id{};
  std::int16_t param_index = 0;
  static constexpr auto Fields() {
    using M = MavParamRequestRead;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("param_id", &M::param_id), MavField("param_index", &M::param_index));
  }
  bool operator==(const MavParamRequestRead&) const = default;
};

// Asks for all parameters.
struct MavParamRequestList {
  static constexpr std::uint32_t kId = 21;
  static constexpr std::string_view kName = "PARAM_REQUEST_LIST";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  static constexpr auto Fields() {
    using M = MavParamRequestList;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component));
  }
  bool operator==(const MavParamRequestList&) const = default;
};

// A parameter: answer to 20, 21 and 23.
struct MavParamValue {
  static constexpr std::uint32_t kId = 22;
  static constexpr std::string_view kName = "PARAM_VALUE";
  std::array<char, 16> param_id{};
  float param_value = 0;
  MavParamType param_type{};
  std::uint16_t param_count = 0;
  std::uint16_t param_index = 0;
  static constexpr auto Fields() {
    using M = MavParamValue;
    return std::tuple(MavField("param_id", &M::param_id), MavField("param_value", &M::param_value),
                      MavField("param_type", &M::param_type),
                      MavField("param_count", &M::param_count),
                      MavField("param_index", &M::param_index));
  }
  bool operator==(const MavParamValue&) const = default;
};

// Sets a parameter; the answer is PARAM_VALUE.
struct MavParamSet {
  static constexpr std::uint32_t kId = 23;
  static constexpr std::string_view kName = "PARAM_SET";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<char, 16> param_id{};
  float param_value = 0;
  MavParamType param_type{};
  static constexpr auto Fields() {
    using M = MavParamSet;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("param_id", &M::param_id), MavField("param_value", &M::param_value),
                      MavField("param_type", &M::param_type));
  }
  bool operator==(const MavParamSet&) const = default;
};

// Quality of a radio modem.
struct MavRadioStatus {
  static constexpr std::uint32_t kId = 109;
  static constexpr std::string_view kName = "RADIO_STATUS";
  std::uint8_t rssi = 0;
  std::uint8_t remrssi = 0;
  std::uint8_t txbuf = 0;  // %
  std::uint8_t noise = 0;
  std::uint8_t remnoise = 0;
  std::uint16_t rxerrors = 0;
  std::uint16_t fixed = 0;
  static constexpr auto Fields() {
    using M = MavRadioStatus;
    return std::tuple(MavField("rssi", &M::rssi), MavField("remrssi", &M::remrssi),
                      MavField("txbuf", &M::txbuf), MavField("noise", &M::noise),
                      MavField("remnoise", &M::remnoise), MavField("rxerrors", &M::rxerrors),
                      MavField("fixed", &M::fixed));
  }
  bool operator==(const MavRadioStatus&) const = default;
};

// Envelope of MAVLink FTP (ftp_payload.h).
struct MavFileTransferProtocol {
  static constexpr std::uint32_t kId = 110;
  static constexpr std::string_view kName = "FILE_TRANSFER_PROTOCOL";
  std::uint8_t target_network = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<std::uint8_t, 251> payload{};
  static constexpr auto Fields() {
    using M = MavFileTransferProtocol;
    return std::tuple(MavField("target_network", &M::target_network),
                      MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("payload", &M::payload));
  }
  bool operator==(const MavFileTransferProtocol&) const = default;
};

// Round trip and clock offset: a request has tc1 0, the answer the answerer's time.
struct MavTimesync {
  static constexpr std::uint32_t kId = 111;
  static constexpr std::string_view kName = "TIMESYNC";
  std::int64_t tc1 = 0;  // ns
  std::int64_t ts1 = 0;  // ns
  // Extensions.
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  static constexpr auto Fields() {
    using M = MavTimesync;
    return std::tuple(MavField("tc1", &M::tc1), MavField("ts1", &M::ts1),
                      MavExtension("target_system", &M::target_system),
                      MavExtension("target_component", &M::target_component));
  }
  bool operator==(const MavTimesync&) const = default;
};

// Capabilities and version.
struct MavAutopilotVersion {
  static constexpr std::uint32_t kId = 148;
  static constexpr std::string_view kName = "AUTOPILOT_VERSION";
  std::uint64_t capabilities = 0;
  std::uint32_t flight_sw_version = 0;
  std::uint32_t middleware_sw_version = 0;
  std::uint32_t os_sw_version = 0;
  std::uint32_t board_version = 0;
  std::array<std::uint8_t, 8> flight_custom_version{};
  std::array<std::uint8_t, 8> middleware_custom_version{};
  std::array<std::uint8_t, 8> os_custom_version{};
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::uint64_t uid = 0;
  // Extensions.
  std::array<std::uint8_t, 18> uid2{};
  static constexpr auto Fields() {
    using M = MavAutopilotVersion;
    return std::tuple(MavField("capabilities", &M::capabilities),
                      MavField("flight_sw_version", &M::flight_sw_version),
                      MavField("middleware_sw_version", &M::middleware_sw_version),
                      MavField("os_sw_version", &M::os_sw_version),
                      MavField("board_version", &M::board_version),
                      MavField("flight_custom_version", &M::flight_custom_version),
                      MavField("middleware_custom_version", &M::middleware_custom_version),
                      MavField("os_custom_version", &M::os_custom_version),
                      MavField("vendor_id", &M::vendor_id), MavField("product_id", &M::product_id),
                      MavField("uid", &M::uid), MavExtension("uid2", &M::uid2));
  }
  bool operator==(const MavAutopilotVersion&) const = default;
};

// A text for people; longer ones come in chunks with one id.
struct MavStatustext {
  static constexpr std::uint32_t kId = 253;
  static constexpr std::string_view kName = "STATUSTEXT";
  MavSeverity severity{};
  std::array<char, 50> text{};
  // Extensions.
  std::uint16_t id = 0;
  std::uint8_t chunk_seq = 0;
  static constexpr auto Fields() {
    using M = MavStatustext;
    return std::tuple(MavField("severity", &M::severity), MavField("text", &M::text),
                      MavExtension("id", &M::id), MavExtension("chunk_seq", &M::chunk_seq));
  }
  bool operator==(const MavStatustext&) const = default;
};

// Gives the vehicle a signing key, over a link that can be trusted only.
struct MavSetupSigning {
  static constexpr std::uint32_t kId = 256;
  static constexpr std::string_view kName = "SETUP_SIGNING";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<std::uint8_t, 32> secret_key{};
  std::uint64_t initial_timestamp = 0;
  static constexpr auto Fields() {
    using M = MavSetupSigning;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("secret_key", &M::secret_key),
                      MavField("initial_timestamp", &M::initial_timestamp));
  }
  bool operator==(const MavSetupSigning&) const = default;
};

}  // namespace colmap_ext
