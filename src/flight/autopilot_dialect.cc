#include "flight/autopilot_dialect.h"

#include <cmath>
#include <limits>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kCustomMode = MavModeFlag::kCustomModeEnabled;

MavStep Long(const VehicleAddress& address, std::uint8_t component, MavCmd command,
             std::array<float, 7> params) {
  MavCommandLong message;
  message.target_system = address.system;
  message.target_component = component;
  message.command = command;
  message.param1 = params[0];
  message.param2 = params[1];
  message.param3 = params[2];
  message.param4 = params[3];
  message.param5 = params[4];
  message.param6 = params[5];
  message.param7 = params[6];
  MavStep step;
  step.message = message;
  return step;
}

// A place in AMSL: PX4 takes every height so, whatever the frame.
MavStep Place(const VehicleAddress& address, MavCmd command, std::array<float, 4> params,
              const GeoPosition& amsl) {
  MavCommandInt message;
  message.target_system = address.system;
  message.target_component = address.autopilot;
  message.frame = MavCoordinateFrame::kGlobal;
  message.command = command;
  message.param1 = params[0];
  message.param2 = params[1];
  message.param3 = params[2];
  message.param4 = params[3];
  message.x = static_cast<std::int32_t>(std::lround(amsl.lat_deg * 1e7));
  message.y = static_cast<std::int32_t>(std::lround(amsl.lon_deg * 1e7));
  message.z = static_cast<float>(amsl.height_m);
  MavStep step;
  step.message = message;
  return step;
}

MavStep SetMode(const VehicleAddress& address, Px4AutoMode px4, ArduCopterMode copter) {
  const bool is_px4 = address.stack == AutopilotStack::kPx4;
  const float main = is_px4 ? static_cast<float>(Px4MainMode::kAuto) : static_cast<float>(copter);
  const float sub = is_px4 ? static_cast<float>(px4) : 0;
  return Long(address, address.autopilot, MavCmd::kDoSetMode, {kCustomMode, main, sub, 0, 0, 0, 0});
}

float HeadingDeg(double yaw_rad) {
  const double degrees = RadToDeg(NormalizeAngle(yaw_rad));
  return static_cast<float>(degrees < 0 ? degrees + 360 : degrees);
}

MavStep Turn(const VehicleAddress& address, double yaw_rad) {
  return Long(address, address.autopilot, MavCmd::kConditionYaw,
              {HeadingDeg(yaw_rad), 0, 0, 0, 0, 0, 0});
}

// Never with the flag that changes the mode: a repeated target must not take the vehicle back from
// a pilot who has just taken it. Without it PX4's commander answers UNSUPPORTED, and its navigator
// goes when the mode is Hold (Commander.cpp and navigator_main.cpp of 1.15); the machine looks at
// the reported target and the motion anyway.
std::vector<MavStep> GoTo(const FlightCommand& command, const VehicleAddress& address) {
  const bool is_px4 = address.stack == AutopilotStack::kPx4;
  const auto yaw = static_cast<float>(is_px4 ? NormalizeAngle(command.yaw_rad) : 0);
  std::vector<MavStep> steps = {Place(address, MavCmd::kDoReposition,
                                      {static_cast<float>(command.speed_m_s), 0, 0, yaw},
                                      command.target)};
  steps[0].may_be_unsupported = is_px4;
  // ArduPilot ignores a target's yaw.
  if (!is_px4) steps.push_back(Turn(address, command.yaw_rad));
  return steps;
}

std::vector<MavStep> Takeoff(const FlightCommand& command, const VehicleAddress& address) {
  if (address.stack == AutopilotStack::kPx4) {
    return {Place(address, MavCmd::kNavTakeoff, {0, 0, 0, kNan}, command.target)};
  }
  return {Long(address, address.autopilot, MavCmd::kNavTakeoff,
               {0, 0, 0, 0, 0, 0, static_cast<float>(command.relative_height_m)})};
}

std::vector<MavStep> Hold(const FlightCommand& command, const VehicleAddress& address) {
  std::vector<MavStep> steps = {SetMode(address, Px4AutoMode::kHold, ArduCopterMode::kBrake)};
  if (address.stack == AutopilotStack::kPx4) {
    // In Hold already, it would fly on to its last target.
    steps.push_back(Place(address, MavCmd::kDoReposition, {-1, 0, 0, kNan}, command.target));
    steps.back().may_be_unsupported = true;
  }
  return steps;
}

MavStep MountControl(const VehicleAddress& address, double pitch_rad) {
  return Long(address, address.autopilot, MavCmd::kDoMountControl,
              {static_cast<float>(RadToDeg(pitch_rad)), 0, 0, 0, 0, 0,
               static_cast<float>(MavMountMode::kMavlinkTargeting)});
}

std::vector<MavStep> Aim(const FlightCommand& command, const VehicleAddress& address) {
  if (!address.has_gimbal_v2) return {MountControl(address, command.pitch_rad)};
  std::vector<MavStep> steps;
  if (!address.owns_gimbal) {
    MavStep configure = Long(address, address.autopilot, MavCmd::kDoGimbalManagerConfigure,
                             {static_cast<float>(address.own_system),
                              static_cast<float>(address.own_component), -1, -1, 0, 0, 0});
    configure.may_fail = true;
    configure.tries = 2;
    steps.push_back(configure);
  }
  // ArduPilot refuses NaN for "no rate"; PX4 takes a rate of 0 as one to be held.
  const float rate = address.stack == AutopilotStack::kPx4 ? kNan : 0;
  const float flags = MavGimbalFlag::kRollLock | MavGimbalFlag::kPitchLock;
  MavStep aim = Long(address, address.autopilot, MavCmd::kDoGimbalManagerPitchyaw,
                     {static_cast<float>(RadToDeg(command.pitch_rad)), 0, rate, rate, flags, 0, 0});
  aim.otherwise = {MountControl(address, command.pitch_rad)};
  steps.push_back(aim);
  return steps;
}

// Repeated with the same sequence number, which a camera takes for the same picture.
std::vector<MavStep> Capture(const FlightCommand& command, const VehicleAddress& address) {
  MavStep shoot =
      Long(address, address.autopilot, MavCmd::kDoDigicamControl, {0, 0, 0, 0, 1, 0, 0});
  shoot.tries = 1;  // has no number: repeating it would take another picture
  if (!address.has_camera_v2) return {shoot};
  MavStep start = Long(address, address.camera, MavCmd::kImageStartCapture,
                       {0, 0, 1, static_cast<float>(command.sequence), 0, 0, 0});
  start.otherwise = {shoot};
  return {start};
}

}  // namespace

VehicleMode ModeOf(AutopilotStack stack, std::uint32_t custom_mode) {
  if (stack == AutopilotStack::kPx4) {
    const Px4Mode mode = Px4ModeOf(custom_mode);
    if (mode.main != Px4MainMode::kAuto) return VehicleMode::kPilot;
    switch (mode.sub) {
      case Px4AutoMode::kTakeoff:
        return VehicleMode::kTakeoff;
      case Px4AutoMode::kHold:
        return VehicleMode::kGuided;
      case Px4AutoMode::kMission:
        return VehicleMode::kMission;
      case Px4AutoMode::kReturn:
        return VehicleMode::kReturn;
      case Px4AutoMode::kLand:
        return VehicleMode::kLand;
      default:
        return VehicleMode::kPilot;
    }
  }
  switch (static_cast<ArduCopterMode>(custom_mode)) {
    case ArduCopterMode::kGuided:
      return VehicleMode::kGuided;
    case ArduCopterMode::kBrake:
      return VehicleMode::kBrake;
    case ArduCopterMode::kAuto:
      return VehicleMode::kMission;
    case ArduCopterMode::kRtl:
    case ArduCopterMode::kSmartRtl:
      return VehicleMode::kReturn;
    case ArduCopterMode::kLand:
      return VehicleMode::kLand;
    default:
      return VehicleMode::kPilot;
  }
}

std::string ModeName(AutopilotStack stack, std::uint32_t custom_mode) {
  const bool is_px4 = stack == AutopilotStack::kPx4;
  switch (ModeOf(stack, custom_mode)) {
    case VehicleMode::kGuided:
      return is_px4 ? "HOLD" : "GUIDED";
    case VehicleMode::kBrake:
      return "BRAKE";
    case VehicleMode::kTakeoff:
      return "TAKEOFF";
    case VehicleMode::kMission:
      return is_px4 ? "MISSION" : "AUTO";
    case VehicleMode::kReturn:
      return "RTL";
    case VehicleMode::kLand:
      return "LAND";
    default:
      return "a pilot's mode (" + std::to_string(custom_mode) + ")";
  }
}

std::vector<MavStep> StepsOf(const FlightCommand& command, const VehicleAddress& address) {
  switch (command.kind) {
    case CommandKind::kGuided:
      return {SetMode(address, Px4AutoMode::kHold, ArduCopterMode::kGuided)};
    case CommandKind::kArm:
      return {Long(address, address.autopilot, MavCmd::kComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0})};
    case CommandKind::kTakeoff:
      return Takeoff(command, address);
    case CommandKind::kGoTo:
      return GoTo(command, address);
    case CommandKind::kTurn:
      if (address.stack == AutopilotStack::kPx4) return {};  // the target's yaw did it
      return {Turn(address, command.yaw_rad)};
    case CommandKind::kAim:
      return Aim(command, address);
    case CommandKind::kCapture:
      return Capture(command, address);
    case CommandKind::kHold:
      return Hold(command, address);
    case CommandKind::kReturn:
      return {SetMode(address, Px4AutoMode::kReturn, ArduCopterMode::kRtl)};
    case CommandKind::kLand:
      return {SetMode(address, Px4AutoMode::kLand, ArduCopterMode::kLand)};
    case CommandKind::kPreflight:
    case CommandKind::kAskCamera:
      break;
  }
  return {};
}

MavStep RequestMessage(const VehicleAddress& address, std::uint8_t component,
                       std::uint32_t message_id, float argument) {
  MavStep step = Long(address, component, MavCmd::kRequestMessage,
                      {static_cast<float>(message_id), argument, 0, 0, 0, 0, 0});
  step.may_fail = true;
  step.tries = 3;
  return step;
}

MavStep SetRate(const VehicleAddress& address, std::uint32_t message_id, double hertz) {
  const double interval_us = hertz > 0 ? 1e6 / hertz : -1;
  MavStep step =
      Long(address, address.autopilot, MavCmd::kSetMessageInterval,
           {static_cast<float>(message_id), static_cast<float>(interval_us), 0, 0, 0, 0, 0});
  step.may_fail = true;
  step.tries = 3;
  return step;
}

}  // namespace colmap_ext
