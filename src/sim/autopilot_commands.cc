// What a ground station asks for.
#include <algorithm>
#include <cmath>

#include "sim/autopilot_impl.h"

namespace colmap_ext {
namespace {

DroneCommand FromLong(const MavCommandLong& message, const MavFrame& frame) {
  DroneCommand command;
  command.id = message.command;
  command.param = {message.param1, message.param2, message.param3, message.param4};
  command.p5 = message.param5;
  command.p6 = message.param6;
  command.p7 = message.param7;
  if (std::isfinite(message.param5)) command.lat_deg = static_cast<double>(message.param5);
  if (std::isfinite(message.param6)) command.lon_deg = static_cast<double>(message.param6);
  command.system = frame.system_id;
  command.component = frame.component_id;
  return command;
}

DroneCommand FromInt(const MavCommandInt& message, const MavFrame& frame) {
  DroneCommand command;
  command.id = message.command;
  command.param = {message.param1, message.param2, message.param3, message.param4};
  constexpr std::int32_t kKeep = 0x7fffffff;
  if (message.x != kKeep) command.lat_deg = message.x * 1e-7;
  if (message.y != kKeep) command.lon_deg = message.y * 1e-7;
  command.p5 = static_cast<float>(message.x);
  command.p6 = static_cast<float>(message.y);
  command.p7 = message.z;
  command.frame = message.frame;
  command.is_int = true;
  command.system = frame.system_id;
  command.component = frame.component_id;
  return command;
}

bool IsMotion(MavCmd id) {
  switch (id) {
    case MavCmd::kNavTakeoff:
    case MavCmd::kDoReposition:
    case MavCmd::kConditionYaw:
    case MavCmd::kMissionStart:
    case MavCmd::kDoSetMode:
    case MavCmd::kNavReturnToLaunch:
    case MavCmd::kNavLand:
      return true;
    default:
      return false;
  }
}

bool IsCapture(MavCmd id) {
  return id == MavCmd::kImageStartCapture || id == MavCmd::kDoDigicamControl;
}

}  // namespace

void SimulatedAutopilot::Impl::Receive(const MavFrame& frame) {
  if (const auto heartbeat = UnpackMav<MavHeartbeat>(frame)) {
    // ArduPilot listens to one ground station only.
    const bool is_gcs = heartbeat->type == MavType::kGcs ||
                        (is_px4 && heartbeat->type == MavType::kOnboardController);
    const bool is_mine = is_px4 || frame.system_id == parameters.GetInt("SYSID_MYGCS");
    if (is_gcs && is_mine) gcs_heard_s = Now();
    return;
  }
  const auto is_for_us = [&](const auto& message) {
    return (message.target_system == 0 || message.target_system == options.system_id) &&
           (message.target_component == 0 || message.target_component == MavComponent::kAutopilot ||
            message.target_component == MavComponent::kCamera);
  };
  if (const auto message = UnpackMav<MavCommandLong>(frame); message && is_for_us(*message)) {
    ReceiveCommand(FromLong(*message, frame), message->target_component);
  }
  if (const auto message = UnpackMav<MavCommandInt>(frame); message && is_for_us(*message)) {
    ReceiveCommand(FromInt(*message, frame), message->target_component);
  }
  const auto send = [this](const MavParamValue& value) { Send(value); };
  if (const auto message = UnpackMav<MavParamRequestRead>(frame); message && is_for_us(*message)) {
    parameters.Answer(*message, send);
  }
  if (const auto message = UnpackMav<MavParamRequestList>(frame); message && is_for_us(*message)) {
    parameters.StartList();
  }
  if (const auto message = UnpackMav<MavParamSet>(frame); message && is_for_us(*message)) {
    parameters.Answer(*message, send);
    if (!is_px4 && MavText(message->param_id) == "FENCE_ENABLE") {
      is_fence_on = parameters.GetInt("FENCE_ENABLE") != 0;
    }
  }
  if (const auto message = UnpackMav<MavSetPositionTargetGlobalInt>(frame);
      message && is_for_us(*message)) {
    ReceivePositionTarget(*message);
  }
  if (const auto message = UnpackMav<MavGimbalManagerSetPitchyaw>(frame);
      message && is_for_us(*message)) {
    ReceivePitchYaw(*message, frame);
  }
  if (const auto message = UnpackMav<MavSetupSigning>(frame); message && is_for_us(*message)) {
    // PX4 does not know it; ArduPilot refuses it while armed.
    if (!is_px4 && !is_armed) {
      signing_key.assign(message->secret_key.begin(), message->secret_key.end());
    } else if (!is_px4) {
      Say(MavSeverity::kWarning, "Signing: refused while armed");
    }
  }
  if (const auto message = UnpackMav<MavTimesync>(frame); message && message->tc1 == 0) {
    MavTimesync answer = *message;
    answer.tc1 = time_us * 1000;
    answer.target_system = frame.system_id;
    answer.target_component = frame.component_id;
    Send(answer);
  }
  if (const auto message = UnpackMav<MavPing>(frame); message && message->target_system == 0) {
    MavPing answer = *message;
    answer.target_system = frame.system_id;
    answer.target_component = frame.component_id;
    Send(answer);
  }
  missions.Receive(frame, Now());
}

void SimulatedAutopilot::Impl::ReceiveCommand(const DroneCommand& command,
                                              std::uint8_t target_component) {
  if (IsMotion(command.id)) {
    ++motion_commands;
    last_motion_command_s = Now();
  }
  arm_commands += command.id == MavCmd::kComponentArmDisarm ? 1 : 0;
  capture_commands += IsCapture(command.id) ? 1 : 0;
  const bool is_for_camera = target_component == MavComponent::kCamera && is_px4;
  if (target_component == MavComponent::kCamera && !is_px4) return;  // no such component
  const std::optional<MavResult> camera = HandleCamera(command);
  if (camera) return Acknowledge(command, *camera, true);
  if (is_for_camera) return Acknowledge(command, MavResult::kUnsupported, true);
  const std::optional<MavResult> result = Handle(command);
  if (result) Acknowledge(command, *result, false);
}

void SimulatedAutopilot::Impl::Acknowledge(const DroneCommand& command, MavResult result,
                                           bool from_camera) {
  MavCommandAck ack;
  ack.command = command.id;
  ack.result = result;
  ack.target_system = command.system;
  ack.target_component = command.component;
  if (from_camera) {
    SendFromCamera(ack);
  } else {
    Send(ack);
  }
}

std::optional<MavResult> SimulatedAutopilot::Impl::Handle(const DroneCommand& command) {
  if (const auto result = HandleGimbal(command)) return result;
  if (const auto result = HandleFlight(command)) return result;
  switch (command.id) {
    case MavCmd::kSetMessageInterval:
      return HandleInterval(command);
    case MavCmd::kRequestMessage:
      return HandleRequest(static_cast<std::uint32_t>(std::lround(command.param[0])));
    case MavCmd::kRequestAutopilotCapabilities:
      return HandleRequest(MavAutopilotVersion::kId);
    case MavCmd::kGetHomePosition:
      return HandleRequest(MavHomePosition::kId);
    case MavCmd::kDoFenceEnable:
      if (is_px4) return MavResult::kUnsupported;
      is_fence_on = command.param[0] != 0;
      return MavResult::kAccepted;
    case MavCmd::kRunPrearmChecks:
      return is_armed ? MavResult::kTemporarilyRejected : MavResult::kAccepted;
    default:
      return MavResult::kUnsupported;
  }
}

std::optional<MavResult> SimulatedAutopilot::Impl::HandleFlight(const DroneCommand& command) {
  const auto enter = [&](FlightMode next) {
    if (EnterMode(next)) return MavResult::kAccepted;
    return is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed;
  };
  switch (command.id) {
    case MavCmd::kComponentArmDisarm:
      return Arm(command.param[0] != 0, std::lround(command.param[1]) == 21196);
    case MavCmd::kDoSetMode:
      return HandleSetMode(command);
    case MavCmd::kNavTakeoff: {
      // PX4 takes AMSL whatever the frame says; ArduPilot a height above home.
      const double z = static_cast<double>(command.p7);
      if (is_px4) {
        return Takeoff(std::isfinite(z) ? z - origin.height_m
                                        : Estimated().z() + parameters.Get("MIS_TAKEOFF_ALT"));
      }
      if (!std::isfinite(z) || !home) return MavResult::kFailed;
      return Takeoff(home->z() + z);
    }
    case MavCmd::kDoReposition:
      return HandleReposition(command);
    case MavCmd::kConditionYaw:
      return HandleConditionYaw(command);
    case MavCmd::kNavReturnToLaunch:
      return enter(FlightMode::kReturn);
    case MavCmd::kNavLand:
      return enter(FlightMode::kLand);
    case MavCmd::kMissionStart:
      return enter(FlightMode::kMission);
    case MavCmd::kDoChangeSpeed:
      if (!std::isfinite(command.param[1]) || command.param[1] <= 0) return MavResult::kDenied;
      speed_m_s = static_cast<double>(command.param[1]);
      return MavResult::kAccepted;
    case MavCmd::kDoPauseContinue:
      if (is_px4) return MavResult::kUnsupported;
      if (mode != FlightMode::kGuided && mode != FlightMode::kMission) return MavResult::kDenied;
      SetGoal(Estimated());
      return MavResult::kAccepted;
    default:
      return std::nullopt;
  }
}

MavResult SimulatedAutopilot::Impl::HandleSetMode(const DroneCommand& command) {
  const auto refused = is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed;
  if ((std::lround(command.param[0]) & MavModeFlag::kCustomModeEnabled) == 0) {
    return is_px4 ? MavResult::kDenied : MavResult::kUnsupported;
  }
  // PX4: (1, main, sub); ArduPilot: (1, mode).
  const auto main = static_cast<std::uint32_t>(std::lround(command.param[1]));
  const auto sub = static_cast<std::uint32_t>(std::lround(command.param[2]));
  const std::uint32_t custom_mode = is_px4 ? (main << 16U | sub << 24U) : main;
  for (const FlightModeInfo& info : FlightModesOf(options.personality)) {
    if (info.custom_mode == custom_mode) {
      return EnterMode(info.mode) ? MavResult::kAccepted : refused;
    }
  }
  return is_px4 ? MavResult::kDenied : MavResult::kFailed;
}

// z of the world that a command's height means; nothing for a frame that is refused. PX4 takes AMSL
// whatever the frame says.
std::optional<double> SimulatedAutopilot::Impl::GoalHeight(const DroneCommand& command) const {
  const double z = static_cast<double>(command.p7);
  if (!std::isfinite(z)) return is_px4 ? std::optional(goal.z()) : std::nullopt;
  if (is_px4) return z - origin.height_m;
  switch (command.frame) {
    case MavCoordinateFrame::kGlobal:
    case MavCoordinateFrame::kGlobalInt:
      return z - origin.height_m;
    case MavCoordinateFrame::kGlobalRelativeAlt:
    case MavCoordinateFrame::kGlobalRelativeAltInt:
    case MavCoordinateFrame::kGlobalTerrainAlt:
    case MavCoordinateFrame::kGlobalTerrainAltInt:
      return z + (home ? home->z() : 0);
    default:
      return std::nullopt;
  }
}

MavResult SimulatedAutopilot::Impl::HandleReposition(const DroneCommand& command) {
  const bool changes_mode = (std::lround(command.param[1]) & 1) != 0;
  const std::optional<double> z = GoalHeight(command);
  if (!is_px4 && mode != FlightMode::kGuided && !changes_mode) return MavResult::kDenied;
  if (!z || (!is_px4 && (!command.lat_deg || !command.lon_deg))) return MavResult::kDenied;
  const GeoPosition here = Geo(goal);
  const GeoPosition place{command.lat_deg.value_or(here.lat_deg),
                          command.lon_deg.value_or(here.lon_deg), origin.height_m + *z};
  if (!IsValid(place)) return MavResult::kDenied;
  const Eigen::Vector3d next = EnuFromGeo(origin, place);
  const bool is_inside = IsInsideFence(next);
  if (!is_px4 && !is_inside) return MavResult::kFailed;
  // PX4's commander does not support it without the flag; its navigator goes all the same when the
  // mode is Hold already (Commander.cpp, navigator_main.cpp of 1.15).
  const bool is_unsupported = is_px4 && !changes_mode;
  if (is_unsupported && mode != FlightMode::kGuided) return MavResult::kUnsupported;
  if (!EnterMode(FlightMode::kGuided)) {
    return is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed;
  }
  const MavResult result = is_unsupported ? MavResult::kUnsupported : MavResult::kAccepted;
  if (!is_inside) {
    // Accepted, and not flown to.
    Say(MavSeverity::kCritical, "Reposition is outside geofence");
    return result;
  }
  is_taking_off = is_taking_off && is_landed;
  SetGoal(next);
  if (command.param[0] > 0) speed_m_s = static_cast<double>(command.param[0]);
  // PX4 takes radians; ArduPilot ignores the yaw and turns into the flight.
  if (is_px4 && std::isfinite(command.param[3])) {
    goal_yaw = static_cast<double>(command.param[3]);
  }
  yaw_follows_travel = !is_px4 && parameters.GetInt("WP_YAW_BEHAVIOR") != 0;
  return result;
}

MavResult SimulatedAutopilot::Impl::HandleConditionYaw(const DroneCommand& command) {
  if (is_px4) return MavResult::kUnsupported;
  if (mode != FlightMode::kGuided || !std::isfinite(command.param[0])) return MavResult::kFailed;
  const double angle = DegToRad(static_cast<double>(command.param[0]));
  const bool is_relative = command.param[3] != 0;
  const double sign = command.param[2] < 0 ? -1 : 1;
  goal_yaw = NormalizeAngle(is_relative ? motion.state().yaw_rad + sign * angle : angle);
  yaw_follows_travel = false;
  return MavResult::kAccepted;
}

// ArduPilot in GUIDED; silently ignored elsewhere and for a place outside the fence. PX4 would need
// a stream in OFFBOARD mode, which this vehicle has not.
void SimulatedAutopilot::Impl::ReceivePositionTarget(const MavSetPositionTargetGlobalInt& target) {
  ++motion_commands;
  last_motion_command_s = Now();
  if (is_px4 || mode != FlightMode::kGuided) return;
  if ((target.type_mask & MavTargetIgnore::kPosition) != 0) return;
  DroneCommand place;
  place.frame = target.coordinate_frame;
  place.p7 = target.alt;
  const std::optional<double> z = GoalHeight(place);
  const GeoPosition where{target.lat_int * 1e-7, target.lon_int * 1e-7,
                          origin.height_m + z.value_or(0)};
  if (!z || !IsValid(where)) return;
  const Eigen::Vector3d next = EnuFromGeo(origin, where);
  if (!IsInsideFence(next)) return;
  SetGoal(next);
  yaw_follows_travel = (target.type_mask & MavTargetIgnore::kYaw) != 0;
  if (!yaw_follows_travel) goal_yaw = NormalizeAngle(static_cast<double>(target.yaw));
}

MavResult SimulatedAutopilot::Impl::HandleRequest(std::uint32_t message_id) {
  if (message_id == MavHomePosition::kId && !home) return MavResult::kTemporarilyRejected;
  return SendById(message_id) ? MavResult::kAccepted : MavResult::kUnsupported;
}

MavResult SimulatedAutopilot::Impl::HandleInterval(const DroneCommand& command) {
  if (!(command.param[0] >= 0) || !std::isfinite(command.param[1])) return MavResult::kDenied;
  const auto id = static_cast<std::uint32_t>(std::lround(command.param[0]));
  const double interval_us = static_cast<double>(command.param[1]);
  if (interval_us < 0) {
    streams.erase(id);
  } else if (interval_us == 0) {
    streams[id].first = 1'000'000;
  } else {
    streams[id].first = std::max<std::int64_t>(kSimulationStepUs, std::llround(interval_us));
  }
  return MavResult::kAccepted;
}

}  // namespace colmap_ext
