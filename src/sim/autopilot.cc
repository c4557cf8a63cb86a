#include "colmap_ext/sim/autopilot.h"

#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"
#include "sim/autopilot_impl.h"

namespace colmap_ext {
AutopilotPersonality ParsePersonality(const std::string& name) {
  if (name == "px4") return AutopilotPersonality::kPx4;
  if (name == "ardupilot") return AutopilotPersonality::kArduPilot;
  throw UsageError("no personality '" + name + "'; there are px4 and ardupilot");
}

SimulatedAutopilot::Impl::Impl(const AutopilotOptions& o, const GeoPosition& scene_origin,
                               const Eigen::Vector3d& home_in_world,
                               VehicleMotion::GroundHeight ground)
    : options(o),
      origin(scene_origin),
      is_px4(o.personality == AutopilotPersonality::kPx4),
      motion(o.motion, home_in_world, DegToRad(o.home_yaw_deg), 101 * o.seed + 1,
             std::move(ground)),
      gps(o.gps, 101 * o.seed + 2),
      battery(o.battery),
      gimbal(o.gimbal, 101 * o.seed + 3),
      parameters(o.personality, o.failsafes, o.parameters),
      missions(o.personality,
               [this](const DroneMissions::Message& message) {
                 std::visit([this](const auto& each) { Send(each); }, message);
               }),
      autopilot_sender(static_cast<std::uint8_t>(o.system_id), MavComponent::kAutopilot),
      camera_sender(static_cast<std::uint8_t>(o.system_id), MavComponent::kCamera),
      mode(is_px4 ? FlightMode::kGuided : FlightMode::kStabilize) {
  goal = motion.state().position;
  goal_yaw = motion.state().yaw_rad;
  is_fence_on = !is_px4 && parameters.GetInt("FENCE_ENABLE") != 0;
  // Rates of the link to a ground station; SET_MESSAGE_INTERVAL changes them.
  const std::pair<std::uint32_t, double> rates[] = {
      {MavHeartbeat::kId, 1},
      {MavSysStatus::kId, 1},
      {MavGpsRawInt::kId, 2},
      {MavGlobalPositionInt::kId, 5},
      {MavAttitude::kId, 5},
      {MavBatteryStatus::kId, 0.5},
      {MavExtendedSysState::kId, 2},
      {is_px4 ? MavEstimatorStatus::kId : MavEkfStatusReport::kId, 1},
      {MavHomePosition::kId, 0.5},
      {MavPositionTargetGlobalInt::kId, 2},
      {MavMissionCurrent::kId, 1},
      {MavGimbalManagerStatus::kId, 0.2},
      {MavGimbalDeviceAttitudeStatus::kId, 5},
      {is_px4 ? MavMountOrientation::kId : MavMountStatus::kId, 5}};
  for (const auto& [id, hertz] : rates) {
    streams[id] = {static_cast<std::int64_t>(1e6 / hertz), 0};
  }
}

void SimulatedAutopilot::Impl::Tick() {
  time_us += kSimulationStepUs;
  gps.Step(kSimulationStepS);
  StepFlight();
  motion.Step(kSimulationStepS, gps.EstimateError());
  battery.Step(kSimulationStepS, motion.state(), is_armed);
  gimbal.Step(kSimulationStepS, motion.state().yaw_rad);
  StepLanded();
  StepFailsafes();
  StepCamera();
  missions.Step(Now());
  for (const MavMissionType type : missions.TakeChanges()) {
    if (type == MavMissionType::kFence) fence.SetItems(missions.Items(type), origin);
    if (type == MavMissionType::kMission) mission_item = -1;
  }
  if (time_us % 20'000 == 0) {
    parameters.StepList([this](const MavParamValue& value) { Send(value); });
  }
  UpdateHome();
  StepTelemetry();
}

// Home is where it stands when the estimate is good, until it is armed.
void SimulatedAutopilot::Impl::UpdateHome() {
  if (is_armed || !HasPosition() || time_us % 1'000'000 != 0) return;
  home = Estimated();
  MavMissionItemInt item;
  const GeoPosition place = Geo(*home);
  item.command = MavCmd::kNavWaypoint;
  item.frame = MavCoordinateFrame::kGlobal;
  item.x = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
  item.y = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
  item.z = static_cast<float>(place.height_m);
  missions.SetHome(item);
}

void SimulatedAutopilot::Impl::Say(MavSeverity severity, const std::string& text) {
  MavStatustext message;
  message.severity = severity;
  SetMavText(text, &message.text);
  Send(message);
}

SimulatedAutopilot::SimulatedAutopilot(const AutopilotOptions& options, const GeoPosition& origin,
                                       const Eigen::Vector3d& home_in_world,
                                       VehicleMotion::GroundHeight ground) {
  ThrowIfInvalid(options.Check());
  impl_ = std::make_unique<Impl>(options, origin, home_in_world, std::move(ground));
}

SimulatedAutopilot::~SimulatedAutopilot() = default;

void SimulatedAutopilot::Receive(const MavFrame& frame) { impl_->Receive(frame); }

void SimulatedAutopilot::Step(double dt_s) {
  impl_->pending_us += std::llround(dt_s * 1e6);
  for (; impl_->pending_us >= kSimulationStepUs; impl_->pending_us -= kSimulationStepUs) {
    impl_->Tick();
  }
}

std::vector<MavFrame> SimulatedAutopilot::TakeFrames() { return std::exchange(impl_->frames, {}); }

std::vector<ShutterEvent> SimulatedAutopilot::TakeShutterEvents() {
  return std::exchange(impl_->shutter_events, {});
}

std::vector<std::uint8_t> SimulatedAutopilot::TakeSigningKey() {
  return std::exchange(impl_->signing_key, {});
}

void SimulatedAutopilot::SendAsCamera(const MavFileTransferProtocol& message) {
  impl_->frames.push_back(impl_->camera_sender.Next(message));
}

void SimulatedAutopilot::SetPictureUrl(const std::string& url) { impl_->picture_url = url; }

void SimulatedAutopilot::PilotSwitch(const std::string& name) {
  for (const FlightModeInfo& info : FlightModesOf(impl_->options.personality)) {
    if (name != info.name) continue;
    if (!impl_->EnterMode(info.mode)) throw UsageError("the vehicle refuses mode " + name);
    ++impl_->pilot_takeovers;
    return;
  }
  throw UsageError("no mode '" + name + "'");
}

std::vector<std::string> SimulatedAutopilot::ModeNames() const {
  std::vector<std::string> names;
  for (const auto& info : FlightModesOf(impl_->options.personality)) names.emplace_back(info.name);
  return names;
}

void SimulatedAutopilot::SetGpsGlitch(double east_m) { impl_->gps.SetGlitch({east_m, 0, 0}); }
void SimulatedAutopilot::SetGpsLost(bool is_lost) { impl_->gps.SetLost(is_lost); }
void SimulatedAutopilot::SetCameraFault(CameraFault fault) { impl_->camera_fault = fault; }
void SimulatedAutopilot::SetGimbalStuck(bool is_stuck) { impl_->gimbal.SetStuck(is_stuck); }
void SimulatedAutopilot::SetBatteryPercent(double percent) { impl_->battery.SetPercent(percent); }
void SimulatedAutopilot::SetWind(const WindOptions& wind) { impl_->motion.SetWind(wind); }

DroneTruth SimulatedAutopilot::Truth() const {
  const Impl& impl = *impl_;
  DroneTruth truth;
  truth.time_s = impl.Now();
  truth.motion = impl.motion.state();
  truth.gimbal_pitch_rad = impl.gimbal.pitch_rad();
  truth.gimbal_heading_rad = impl.gimbal.Heading(truth.motion.yaw_rad);
  truth.is_gimbal_stuck = impl.gimbal.is_stuck();
  truth.is_armed = impl.is_armed;
  truth.is_landed = impl.is_landed;
  truth.has_crashed = impl.has_crashed;
  truth.mode = impl.Info().name;
  truth.failsafe = impl.failsafe;
  truth.battery_percent = impl.battery.percent();
  truth.captures = impl.captures;
  truth.pilot_takeovers = impl.pilot_takeovers;
  truth.motion_commands = impl.motion_commands;
  truth.arm_commands = impl.arm_commands;
  truth.capture_commands = impl.capture_commands;
  truth.last_motion_command_s = impl.last_motion_command_s;
  return truth;
}

const AutopilotOptions& SimulatedAutopilot::options() const { return impl_->options; }

}  // namespace colmap_ext
