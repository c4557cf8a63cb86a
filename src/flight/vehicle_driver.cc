#include "colmap_ext/flight/vehicle_driver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"
#include "flight/autopilot_dialect.h"
#include "flight/command_sender.h"
#include "flight/preflight_procedure.h"
#include "flight/telemetry.h"

namespace colmap_ext {
namespace {

// Twice a second: ArduPilot returns after 4.5 s without one, and a fifth of them may be lost.
constexpr double kHeartbeatS = 0.5;
// The vehicle's: a command that moves it waits for the next one. Where this is not granted, it is
// once a second.
constexpr double kModeRateHz = 4;
constexpr double kIntroductionS = 2;      // between rounds of questions who the vehicle is
constexpr int kIntroductionRounds = 4;    // then it is flown without a version
constexpr double kCameraQuestionS = 0.7;  // between questions for one picture's report
constexpr int kMaxPicturesAsked = 20;
constexpr int kInternalTask = -1;

std::string VersionText(AutopilotStack stack, std::uint32_t version) {
  return std::string(Name(stack)) + " " + std::to_string(version >> 24U) + "." +
         std::to_string(version >> 16U & 0xFFU) + "." + std::to_string(version >> 8U & 0xFFU);
}

// The mission's fence, and no-fly zones that reach from the ground up without end: a vehicle's own
// fence knows no heights of polygons. Zones with holes are left to the daemon.
std::vector<FenceCorner> FenceFor(const FlightMission& mission) {
  std::vector<FenceCorner> corners;
  const auto add = [&](const std::vector<Eigen::Vector2d>& polygon, bool is_exclusion) {
    for (const Eigen::Vector2d& corner : polygon) {
      corners.push_back({mission.AmslFromWorld({corner.x(), corner.y(), 0}),
                         static_cast<int>(polygon.size()), is_exclusion});
    }
  };
  add(mission.limits.fence, false);
  for (const FlightZone& zone : mission.limits.site.zones) {
    const bool is_plain = zone.kind == FlightZone::Kind::kExclusion && zone.rings.size() == 1 &&
                          std::isinf(zone.min_z_m) && std::isinf(zone.max_z_m);
    if (is_plain) add(zone.rings[0], true);
  }
  return corners;
}

}  // namespace

std::string DriverOptions::Check() const {
  if (system_id < 1 || system_id > 255) return "Driver.system_id must be from 1 to 255";
  if (component_id < 1 || component_id > 255) return "Driver.component_id must be from 1 to 255";
  if (vehicle_id < 0 || vehicle_id > 255) return "Driver.vehicle_id must be from 0 to 255";
  if (!(position_rate_hz >= 1 && position_rate_hz <= 50)) {
    return "Driver.position_rate_hz must be from 1 to 50";
  }
  return "";
}

void BindOptions(OptionSet& set, DriverOptions* options) {
  set.Add("Driver", "system_id", &options->system_id,
          "our MAVLink system; ArduPilot's failsafe listens to MAV_GCS_SYSID [1 … 255]");
  set.Add("Driver", "component_id", &options->component_id, "our MAVLink component [1 … 255]");
  set.Add("Driver", "vehicle_id", &options->vehicle_id,
          "MAVLink system to fly; 0: the first autopilot that is heard [0 … 255]");
  set.Add("Driver", "position_rate_hz", &options->position_rate_hz,
          "positions asked of the vehicle [Hz, 1 … 50]");
}

struct VehicleDriver::Impl {
  explicit Impl(const DriverOptions& given)
      : options(given),
        sender(static_cast<std::uint8_t>(given.system_id),
               static_cast<std::uint8_t>(given.component_id)) {
    address.own_system = sender.SystemId();
    address.own_component = sender.ComponentId();
  }

  template <typename Message>
  void Send(const Message& message) {
    if (!options.is_shadow) frames.push_back(sender.Next(message));
  }

  bool IsOurVehicle(const MavFrame& frame);
  void OnHeartbeat(const MavHeartbeat& heartbeat, const MavFrame& frame, double now_s);
  void OnVersion(const MavAutopilotVersion& version);
  void OnCaptureStatus(const MavCameraCaptureStatus& status);
  void Introduce(double now_s);
  void AskCamera(const FlightCommand& command, double now_s);
  void TickCamera(double now_s);
  void FinishPreflight();
  void Pump();

  DriverOptions options;
  MavSender sender;
  VehicleAddress address;
  VehicleState vehicle;
  CommandSender commands;
  PreflightProcedure procedure;
  int preflight_id = 0;
  DriverEvents events;
  std::vector<MavFrame> frames;
  bool has_address = false, has_version = false, has_camera = false, has_gimbal = false;
  double heartbeat_due_s = -1e9, introduction_due_s = -1e9;
  int introductions = 0;

  // Reports of pictures that the camera counted and that did not arrive.
  int camera_after_index = -1, camera_next_index = -1, camera_last_index = -1;
  double camera_due_s = 0;
};

bool VehicleDriver::Impl::IsOurVehicle(const MavFrame& frame) {
  if (has_address) return frame.system_id == address.system;
  const auto heartbeat = UnpackMav<MavHeartbeat>(frame);
  if (!heartbeat || frame.component_id != MavComponent::kAutopilot) return false;
  const bool is_known = heartbeat->autopilot == MavAutopilot::kPx4 ||
                        heartbeat->autopilot == MavAutopilot::kArduPilot;
  const bool is_wanted = options.vehicle_id == 0 || frame.system_id == options.vehicle_id;
  if (!is_known || !is_wanted) return false;
  has_address = true;
  address.system = frame.system_id;
  return true;
}

void VehicleDriver::Impl::OnHeartbeat(const MavHeartbeat& heartbeat, const MavFrame& frame,
                                      double now_s) {
  if (frame.component_id != address.autopilot) {
    if (heartbeat.type == MavType::kCamera) address.camera = frame.component_id;
    return;
  }
  UpdateVehicle(frame, now_s, &vehicle);
  address.stack = vehicle.stack;
}

void VehicleDriver::Impl::OnVersion(const MavAutopilotVersion& version) {
  has_version = true;
  vehicle.description = VersionText(vehicle.stack, version.flight_sw_version);
}

// Asks who the vehicle is, and for the messages that are needed.
void VehicleDriver::Impl::Introduce(double now_s) {
  if (!has_address || vehicle.is_identified || now_s < introduction_due_s) return;
  const bool is_known = vehicle.position && vehicle.landed != LandedState::kUnknown &&
                        (vehicle.home || !vehicle.is_armed) &&
                        (has_version || introductions >= kIntroductionRounds);
  if (is_known || (options.is_shadow && vehicle.position)) {
    if (vehicle.description.empty()) vehicle.description = Name(vehicle.stack);
    vehicle.is_identified = true;
    return;
  }
  ++introductions;
  introduction_due_s = now_s + kIntroductionS;
  const bool is_px4 = vehicle.stack == AutopilotStack::kPx4;
  std::vector<MavStep> steps = {
      RequestMessage(address, address.autopilot, MavAutopilotVersion::kId),
      RequestMessage(address, address.autopilot, MavHomePosition::kId),
      SetRate(address, MavGlobalPositionInt::kId, options.position_rate_hz),
      SetRate(address, MavHeartbeat::kId, kModeRateHz),
      SetRate(address, MavExtendedSysState::kId, 2),
      SetRate(address, MavGpsRawInt::kId, 2),
      SetRate(address, is_px4 ? MavEstimatorStatus::kId : MavEkfStatusReport::kId, 1),
      SetRate(address, MavPositionTargetGlobalInt::kId, 2),
      SetRate(address, MavGimbalDeviceAttitudeStatus::kId, 5),
      SetRate(address, MavHomePosition::kId, 0.5),
      SetRate(address, MavAttitude::kId, 1),
      RequestMessage(address, address.camera, MavCameraInformation::kId),
      RequestMessage(address, address.autopilot, MavGimbalManagerInformation::kId)};
  for (MavStep& step : steps) step.tries = 2;
  commands.Start(kInternalTask, CommandKind::kPreflight, std::move(steps), now_s);
}

void VehicleDriver::Impl::AskCamera(const FlightCommand& command, double now_s) {
  camera_after_index = command.after_index;
  camera_next_index = camera_last_index = -1;
  commands.Start(command.id, CommandKind::kAskCamera,
                 {RequestMessage(address, address.camera, MavCameraCaptureStatus::kId)}, now_s);
}

void VehicleDriver::Impl::OnCaptureStatus(const MavCameraCaptureStatus& status) {
  events.picture_count = status.image_count;
  const int last = status.image_count - 1;
  if (camera_after_index < -1 || last <= camera_after_index) return;
  camera_next_index = std::max(camera_after_index + 1, last - kMaxPicturesAsked);
  camera_last_index = last;
  camera_after_index = -2;  // once a question
  camera_due_s = -1e9;
}

void VehicleDriver::Impl::TickCamera(double now_s) {
  if (camera_next_index < 0 || camera_next_index > camera_last_index || now_s < camera_due_s) {
    return;
  }
  camera_due_s = now_s + kCameraQuestionS;
  MavStep ask = RequestMessage(address, address.camera, MavCameraImageCaptured::kId,
                               static_cast<float>(camera_next_index++));
  commands.Start(kInternalTask, CommandKind::kAskCamera, {ask}, now_s);
}

void VehicleDriver::Impl::FinishPreflight() {
  if (preflight_id == 0 || !procedure.IsDone()) return;
  PreflightFacts facts = procedure.facts();
  facts.has_camera = has_camera;
  facts.has_gimbal = has_gimbal || vehicle.gimbal.has_value();
  events.facts = facts;
  events.answers.push_back({preflight_id, CommandOutcome::kAccepted, ""});
  preflight_id = 0;
}

void VehicleDriver::Impl::Pump() {
  for (const MavCommandMessage& message : commands.TakeMessages()) {
    std::visit([this](const auto& each) { Send(each); }, message);
  }
  for (const PreflightMessage& message : procedure.TakeMessages()) {
    std::visit([this](const auto& each) { Send(each); }, message);
  }
  for (const TaskResult& result : commands.TakeResults()) {
    if (result.id == kInternalTask) continue;
    if (result.took_fallback && result.outcome == CommandOutcome::kAccepted) {
      if (result.kind == CommandKind::kAim) address.has_gimbal_v2 = false;
      if (result.kind == CommandKind::kCapture) address.has_camera_v2 = false;
    }
    if (result.kind == CommandKind::kAim) address.owns_gimbal = true;
    events.answers.push_back({result.id, result.outcome, result.text});
  }
  FinishPreflight();
}

VehicleDriver::VehicleDriver(const DriverOptions& options) {
  ThrowIfInvalid(options.Check());
  impl_ = std::make_unique<Impl>(options);
}
VehicleDriver::~VehicleDriver() = default;

void VehicleDriver::Receive(const MavFrame& frame, double now_s) {
  Impl& driver = *impl_;
  if (!driver.IsOurVehicle(frame)) return;
  VehicleState& vehicle = driver.vehicle;
  if (frame.component_id == driver.address.autopilot) vehicle.heard_s = now_s;
  if (const auto heartbeat = UnpackMav<MavHeartbeat>(frame)) {
    driver.OnHeartbeat(*heartbeat, frame, now_s);
  } else if (const auto ack = UnpackMav<MavCommandAck>(frame)) {
    const bool is_ours = ack->target_system == 0 || ack->target_system == driver.options.system_id;
    if (is_ours) driver.commands.OnAck(*ack, now_s);
  } else if (const auto version = UnpackMav<MavAutopilotVersion>(frame)) {
    driver.OnVersion(*version);
  } else if (const auto report = ReadCapture(frame, vehicle)) {
    driver.has_camera = true;
    driver.events.captures.push_back(*report);
  } else if (const auto status = UnpackMav<MavCameraCaptureStatus>(frame)) {
    driver.OnCaptureStatus(*status);
  } else if (frame.message_id == MavCameraInformation::kId) {
    driver.has_camera = true;
    driver.address.camera = frame.component_id;
  } else if (frame.message_id == MavGimbalManagerInformation::kId) {
    driver.has_gimbal = true;
  } else if (const auto text = UnpackMav<MavStatustext>(frame)) {
    driver.events.texts.push_back(MavText(text->text));
  } else if (!UpdateVehicle(frame, now_s, &vehicle)) {
    driver.procedure.Receive(frame, now_s);
  }
  driver.Pump();
}

void VehicleDriver::Execute(const FlightCommand& command, const FlightMission& mission,
                            const FlightOptions& options, double now_s) {
  Impl& driver = *impl_;
  if (command.kind == CommandKind::kPreflight) {
    driver.preflight_id = command.id;
    driver.procedure.Start(driver.address,
                           options.upload_fence ? FenceFor(mission) : std::vector<FenceCorner>(),
                           now_s);
    driver.commands.Start(
        kInternalTask, CommandKind::kPreflight,
        {RequestMessage(driver.address, driver.address.camera, MavCameraInformation::kId),
         RequestMessage(driver.address, driver.address.autopilot, MavHomePosition::kId)},
        now_s);
  } else if (command.kind == CommandKind::kAskCamera) {
    driver.AskCamera(command, now_s);
  } else {
    driver.commands.Start(command.id, command.kind, StepsOf(command, driver.address), now_s);
  }
  driver.Pump();
}

void VehicleDriver::CancelMotion() { impl_->commands.CancelMotion(); }

void VehicleDriver::ReleaseMotion(double now_s) {
  impl_->commands.ReleaseMotion(impl_->vehicle.mode_heard_s, now_s);
  impl_->Pump();
}

void VehicleDriver::Send(const MavFileTransferProtocol& message) { impl_->Send(message); }

void VehicleDriver::Tick(double now_s) {
  Impl& driver = *impl_;
  if (now_s - driver.heartbeat_due_s >= 0) {
    MavHeartbeat heartbeat;
    heartbeat.type = MavType::kGcs;
    heartbeat.autopilot = MavAutopilot::kInvalid;
    heartbeat.system_status = MavState::kActive;
    heartbeat.mavlink_version = 3;
    driver.Send(heartbeat);
    driver.heartbeat_due_s = now_s + kHeartbeatS;
  }
  driver.Introduce(now_s);
  driver.TickCamera(now_s);
  driver.commands.Tick(now_s);
  driver.procedure.Tick(now_s);
  driver.Pump();
}

std::vector<MavFrame> VehicleDriver::TakeFrames() { return std::exchange(impl_->frames, {}); }
DriverEvents VehicleDriver::TakeEvents() { return std::exchange(impl_->events, {}); }
const VehicleState& VehicleDriver::vehicle() const { return impl_->vehicle; }

}  // namespace colmap_ext
