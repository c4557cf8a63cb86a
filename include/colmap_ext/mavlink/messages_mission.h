// Commands, and the mission, fence and rally transfer. Field names, units and
// meanings are MAVLink's own (mavlink.io, common.xml and ardupilotmega.xml).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "colmap_ext/mavlink/enums.h"
#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

// The vehicle asks for an item in the old way; the answer is MISSION_ITEM_INT all the same.
struct MavMissionRequest {
  static constexpr std::uint32_t kId = 40;
  static constexpr std::string_view kName = "MISSION_REQUEST";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint16_t seq = 0;
  // Extensions.
  MavMissionType mission_type{};
  static constexpr auto Fields() {
    using M = MavMissionRequest;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component), MavField("seq", &M::seq),
                      MavExtension("mission_type", &M::mission_type));
  }
  bool operator==(const MavMissionRequest&) const = default;
};

// Which item is flown now.
struct MavMissionCurrent {
  static constexpr std::uint32_t kId = 42;
  static constexpr std::string_view kName = "MISSION_CURRENT";
  std::uint16_t seq = 0;
  // Extensions.
  std::uint16_t total = 0;
  MavMissionState mission_state{};
  std::uint8_t mission_mode = 0;
  std::uint32_t mission_id = 0;
  std::uint32_t fence_id = 0;
  std::uint32_t rally_points_id = 0;
  static constexpr auto Fields() {
    using M = MavMissionCurrent;
    return std::tuple(MavField("seq", &M::seq), MavExtension("total", &M::total),
                      MavExtension("mission_state", &M::mission_state),
                      MavExtension("mission_mode", &M::mission_mode),
                      MavExtension("mission_id", &M::mission_id),
                      MavExtension("fence_id", &M::fence_id),
                      MavExtension("rally_points_id", &M::rally_points_id));
  }
  bool operator==(const MavMissionCurrent&) const = default;
};

// Asks for the list of items.
struct MavMissionRequestList {
  static constexpr std::uint32_t kId = 43;
  static constexpr std::string_view kName = "MISSION_REQUEST_LIST";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Extensions.
  MavMissionType mission_type{};
  static constexpr auto Fields() {
    using M = MavMissionRequestList;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavExtension("mission_type", &M::mission_type));
  }
  bool operator==(const MavMissionRequestList&) const = default;
};

// How many items will follow.
struct MavMissionCount {
  static constexpr std::uint32_t kId = 44;
  static constexpr std::string_view kName = "MISSION_COUNT";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint16_t count = 0;
  // Extensions.
  MavMissionType mission_type{};
  std::uint32_t opaque_id = 0;
  static constexpr auto Fields() {
    using M = MavMissionCount;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("count", &M::count), MavExtension("mission_type", &M::mission_type),
                      MavExtension("opaque_id", &M::opaque_id));
  }
  bool operator==(const MavMissionCount&) const = default;
};

// Deletes all items of a type.
struct MavMissionClearAll {
  static constexpr std::uint32_t kId = 45;
  static constexpr std::string_view kName = "MISSION_CLEAR_ALL";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Extensions.
  MavMissionType mission_type{};
  static constexpr auto Fields() {
    using M = MavMissionClearAll;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavExtension("mission_type", &M::mission_type));
  }
  bool operator==(const MavMissionClearAll&) const = default;
};

// An item was reached.
struct MavMissionItemReached {
  static constexpr std::uint32_t kId = 46;
  static constexpr std::string_view kName = "MISSION_ITEM_REACHED";
  std::uint16_t seq = 0;
  static constexpr auto Fields() {
    using M = MavMissionItemReached;
    return std::tuple(MavField("seq", &M::seq));
  }
  bool operator==(const MavMissionItemReached&) const = default;
};

// End of a transfer, or why it failed.
struct MavMissionAck {
  static constexpr std::uint32_t kId = 47;
  static constexpr std::string_view kName = "MISSION_ACK";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  MavMissionResult type{};
  // Extensions.
  MavMissionType mission_type{};
  std::uint32_t opaque_id = 0;
  static constexpr auto Fields() {
    using M = MavMissionAck;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("type", &M::type), MavExtension("mission_type", &M::mission_type),
                      MavExtension("opaque_id", &M::opaque_id));
  }
  bool operator==(const MavMissionAck&) const = default;
};

// Asks for one item.
struct MavMissionRequestInt {
  static constexpr std::uint32_t kId = 51;
  static constexpr std::string_view kName = "MISSION_REQUEST_INT";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint16_t seq = 0;
  // Extensions.
  MavMissionType mission_type{};
  static constexpr auto Fields() {
    using M = MavMissionRequestInt;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component), MavField("seq", &M::seq),
                      MavExtension("mission_type", &M::mission_type));
  }
  bool operator==(const MavMissionRequestInt&) const = default;
};

// One item of a mission, fence or rally list.
struct MavMissionItemInt {
  static constexpr std::uint32_t kId = 73;
  static constexpr std::string_view kName = "MISSION_ITEM_INT";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint16_t seq = 0;
  MavCoordinateFrame frame{};
  MavCmd command{};
  std::uint8_t current = 0;
  std::uint8_t autocontinue = 0;
  float param1 = 0;
  float param2 = 0;
  float param3 = 0;
  float param4 = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  float z = 0;
  // Extensions.
  MavMissionType mission_type{};
  static constexpr auto Fields() {
    using M = MavMissionItemInt;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component), MavField("seq", &M::seq),
                      MavField("frame", &M::frame), MavField("command", &M::command),
                      MavField("current", &M::current), MavField("autocontinue", &M::autocontinue),
                      MavField("param1", &M::param1), MavField("param2", &M::param2),
                      MavField("param3", &M::param3), MavField("param4", &M::param4),
                      MavField("x", &M::x), MavField("y", &M::y), MavField("z", &M::z),
                      MavExtension("mission_type", &M::mission_type));
  }
  bool operator==(const MavMissionItemInt&) const = default;
};

// A command with a place.
struct MavCommandInt {
  static constexpr std::uint32_t kId = 75;
  static constexpr std::string_view kName = "COMMAND_INT";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  MavCoordinateFrame frame{};
  MavCmd command{};
  std::uint8_t current = 0;
  std::uint8_t autocontinue = 0;
  float param1 = 0;
  float param2 = 0;
  float param3 = 0;
  float param4 = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  float z = 0;
  static constexpr auto Fields() {
    using M = MavCommandInt;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("frame", &M::frame), MavField("command", &M::command),
                      MavField("current", &M::current), MavField("autocontinue", &M::autocontinue),
                      MavField("param1", &M::param1), MavField("param2", &M::param2),
                      MavField("param3", &M::param3), MavField("param4", &M::param4),
                      MavField("x", &M::x), MavField("y", &M::y), MavField("z", &M::z));
  }
  bool operator==(const MavCommandInt&) const = default;
};

// A command.
struct MavCommandLong {
  static constexpr std::uint32_t kId = 76;
  static constexpr std::string_view kName = "COMMAND_LONG";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  MavCmd command{};
  std::uint8_t confirmation = 0;
  float param1 = 0;
  float param2 = 0;
  float param3 = 0;
  float param4 = 0;
  float param5 = 0;
  float param6 = 0;
  float param7 = 0;
  static constexpr auto Fields() {
    using M = MavCommandLong;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("command", &M::command), MavField("confirmation", &M::confirmation),
                      MavField("param1", &M::param1), MavField("param2", &M::param2),
                      MavField("param3", &M::param3), MavField("param4", &M::param4),
                      MavField("param5", &M::param5), MavField("param6", &M::param6),
                      MavField("param7", &M::param7));
  }
  bool operator==(const MavCommandLong&) const = default;
};

// Answer to a command.
struct MavCommandAck {
  static constexpr std::uint32_t kId = 77;
  static constexpr std::string_view kName = "COMMAND_ACK";
  MavCmd command{};
  MavResult result{};
  // Extensions.
  std::uint8_t progress = 0;  // %
  std::int32_t result_param2 = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  static constexpr auto Fields() {
    using M = MavCommandAck;
    return std::tuple(MavField("command", &M::command), MavField("result", &M::result),
                      MavExtension("progress", &M::progress),
                      MavExtension("result_param2", &M::result_param2),
                      MavExtension("target_system", &M::target_system),
                      MavExtension("target_component", &M::target_component));
  }
  bool operator==(const MavCommandAck&) const = default;
};

// Asks to stop a long-running command.
struct MavCommandCancel {
  static constexpr std::uint32_t kId = 80;
  static constexpr std::string_view kName = "COMMAND_CANCEL";
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  MavCmd command{};
  static constexpr auto Fields() {
    using M = MavCommandCancel;
    return std::tuple(MavField("target_system", &M::target_system),
                      MavField("target_component", &M::target_component),
                      MavField("command", &M::command));
  }
  bool operator==(const MavCommandCancel&) const = default;
};

}  // namespace colmap_ext
