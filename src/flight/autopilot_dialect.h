// How PX4 and ArduPilot are told the same things (the table in docs/flying.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/flight/vehicle_state.h"
#include "flight/command_sender.h"

namespace colmap_ext {

// Who is talked to, and what was learned about it.
struct VehicleAddress {
  AutopilotStack stack = AutopilotStack::kUnknown;
  std::uint8_t system = 1;
  std::uint8_t autopilot = MavComponent::kAutopilot;
  std::uint8_t camera = MavComponent::kAutopilot;  // where CAMERA_INFORMATION came from
  std::uint8_t own_system = 255;
  std::uint8_t own_component = MavComponent::kMissionPlanner;
  bool has_gimbal_v2 = true;  // false: refused; MOUNT_CONTROL from then on
  bool has_camera_v2 = true;  // false: refused; DIGICAM_CONTROL from then on
  bool owns_gimbal = false;   // GIMBAL_MANAGER_CONFIGURE was sent
};

VehicleMode ModeOf(AutopilotStack stack, std::uint32_t custom_mode);
std::string ModeName(AutopilotStack stack, std::uint32_t custom_mode);

// The steps of a command; kPreflight and kAskCamera have none here.
std::vector<MavStep> StepsOf(const FlightCommand& command, const VehicleAddress& address);

// MAV_CMD_REQUEST_MESSAGE.
MavStep RequestMessage(const VehicleAddress& address, std::uint8_t component,
                       std::uint32_t message_id, float argument = 0);
// MAV_CMD_SET_MESSAGE_INTERVAL; 0 Hz: not at all.
MavStep SetRate(const VehicleAddress& address, std::uint32_t message_id, double hertz);

}  // namespace colmap_ext
