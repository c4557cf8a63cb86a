// Gimbal and camera, with both generations of their protocols.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/sim/picture_store.h"
#include "sim/autopilot_impl.h"
#include "sim/telemetry_units.h"

namespace colmap_ext {
namespace {

constexpr double kShutterLag_s = 0.15;  // from the command to the exposure
constexpr double kReportLag_s = 0.35;   // from the exposure to the report
// The clock's time when the vehicle is switched on: the same in every run.
constexpr std::uint64_t kPowerOnUnixUs = 1'700'000'000'000'000;

}  // namespace

std::optional<MavResult> SimulatedAutopilot::Impl::HandleGimbal(const DroneCommand& command) {
  const auto& p = command.param;
  switch (command.id) {
    case MavCmd::kDoGimbalManagerConfigure:
      if (options.gimbal_protocol != "v2") return MavResult::kUnsupported;
      // -2: whoever sends this; -1: as it is; 0: nobody.
      for (std::size_t i = 0; i < 2; ++i) {
        const long wanted = std::lround(p[i]);
        if (wanted == -2) gimbal_owner[i] = i == 0 ? command.system : command.component;
        if (wanted >= 0) gimbal_owner[i] = static_cast<std::uint8_t>(wanted);
      }
      SendGimbalStatus();
      return MavResult::kAccepted;
    case MavCmd::kDoGimbalManagerPitchyaw: {
      if (options.gimbal_protocol != "v2") return MavResult::kUnsupported;
      const bool is_owner =
          gimbal_owner[0] == command.system && gimbal_owner[1] == command.component;
      if (is_px4 && !is_owner) return MavResult::kDenied;
      if (!is_px4 && (std::isnan(p[0]) || std::isnan(p[1]) || std::isnan(p[2]))) {
        return MavResult::kDenied;
      }
      return AimGimbal(DegToRad(static_cast<double>(p[0])), DegToRad(static_cast<double>(p[1])),
                       static_cast<std::uint32_t>(std::max(0.0F, command.p5)));
    }
    case MavCmd::kDoMountControl:
      if (options.gimbal_protocol == "none") return MavResult::kUnsupported;
      return AimGimbal(DegToRad(static_cast<double>(p[0])), DegToRad(static_cast<double>(p[2])), 0);
    default:
      return std::nullopt;
  }
}

MavResult SimulatedAutopilot::Impl::AimGimbal(double pitch_rad, double yaw_rad,
                                              std::uint32_t flags) {
  if (!std::isfinite(pitch_rad)) pitch_rad = gimbal.pitch_rad();
  const bool is_locked = (flags & MavGimbalFlag::kYawLock) != 0;
  if (!std::isfinite(yaw_rad)) yaw_rad = is_locked ? motion.state().yaw_rad : 0;
  gimbal.SetTarget(pitch_rad, yaw_rad, is_locked);
  return MavResult::kAccepted;
}

void SimulatedAutopilot::Impl::ReceivePitchYaw(const MavGimbalManagerSetPitchyaw& message,
                                               const MavFrame& frame) {
  if (options.gimbal_protocol != "v2") return;
  if (is_px4 && (gimbal_owner[0] != frame.system_id || gimbal_owner[1] != frame.component_id)) {
    return;
  }
  AimGimbal(static_cast<double>(message.pitch), static_cast<double>(message.yaw), message.flags);
}

std::optional<MavResult> SimulatedAutopilot::Impl::HandleCamera(const DroneCommand& command) {
  const bool is_v2 = options.camera_protocol == "v2";
  switch (command.id) {
    case MavCmd::kDoDigicamControl:
      return command.p5 == 1 ? StartCapture(0) : MavResult::kAccepted;
    case MavCmd::kImageStartCapture:
      if (!is_v2) return MavResult::kUnsupported;
      if (command.param[2] != 1) return MavResult::kDenied;  // one picture at a time
      return StartCapture(static_cast<int>(std::lround(command.param[3])));
    case MavCmd::kImageStopCapture:
    case MavCmd::kSetCameraMode:
      return is_v2 ? MavResult::kAccepted : MavResult::kUnsupported;
    case MavCmd::kRequestCameraInformation:
      if (!is_v2) return MavResult::kUnsupported;
      SendCameraInformation();
      return MavResult::kAccepted;
    case MavCmd::kRequestMessage:
      break;
    default:
      return std::nullopt;
  }
  if (!is_v2) return std::nullopt;
  switch (static_cast<std::uint32_t>(std::lround(command.param[0]))) {
    case MavCameraInformation::kId:
      SendCameraInformation();
      return MavResult::kAccepted;
    case MavCameraSettings::kId:
      SendCameraSettings();
      return MavResult::kAccepted;
    case MavStorageInformation::kId:
      SendStorage();
      return MavResult::kAccepted;
    case MavCameraCaptureStatus::kId:
      SendCaptureStatus();
      return MavResult::kAccepted;
    case MavCameraImageCaptured::kId: {
      // A report that got lost, by the picture's index.
      const auto index = static_cast<std::size_t>(std::max(0.0F, command.param[1]));
      if (!is_px4) return MavResult::kUnsupported;
      if (index >= sent_reports.size()) return MavResult::kDenied;
      SendFromCamera(sent_reports[index]);
      return MavResult::kAccepted;
    }
    default:
      return std::nullopt;
  }
}

MavResult SimulatedAutopilot::Impl::StartCapture(int sequence) {
  if (camera_fault == CameraFault::kRefuses) return MavResult::kFailed;
  // A camera with MAVLink's protocol knows repeats by the sequence number.
  if (is_px4 && sequence > 0 && sequence == last_sequence) return MavResult::kAccepted;
  if (!is_px4 && Now() - last_capture_s < options.capture_spacing_s) return MavResult::kFailed;
  if (shutter_at_s >= 0) return is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed;
  last_sequence = sequence;
  last_capture_s = Now();
  shutter_at_s = Now() + kShutterLag_s;
  return MavResult::kAccepted;
}

void SimulatedAutopilot::Impl::StepCamera() {
  if (shutter_at_s >= 0 && Now() >= shutter_at_s) {
    shutter_at_s = -1;
    TakePicture();
  }
  while (!reports.empty() && reports.front().first <= Now()) {
    ReportPicture(reports.front().second, reports.front().second.index >= 0);
    reports.pop_front();
  }
}

void SimulatedAutopilot::Impl::TakePicture() {
  if (camera_fault == CameraFault::kSilent) return;
  ShutterEvent event;
  event.time_boot_ms = BootMs();
  event.position = motion.state().position;
  event.direction = {gimbal.Heading(motion.state().yaw_rad), gimbal.pitch_rad()};
  event.gps = Geo(motion.state().position + gps.FixError());
  event.sigma_horizontal_m = gps.HorizontalAccuracy();
  event.sigma_vertical_m = gps.VerticalAccuracy();
  event.index = camera_fault == CameraFault::kReports ? -1 : captures;
  if (event.index >= 0) {
    ++captures;
    shutter_events.push_back(event);
  }
  reports.emplace_back(Now() + kReportLag_s, event);
}

void SimulatedAutopilot::Impl::ReportPicture(const ShutterEvent& event, bool is_good) {
  const double relative = event.gps.height_m - (home ? Geo(*home).height_m : event.gps.height_m);
  if (!is_px4) {
    if (!is_good) return;
    MavCameraFeedback message;
    message.time_usec = kPowerOnUnixUs + std::uint64_t{event.time_boot_ms} * 1000;
    message.target_system = static_cast<std::uint8_t>(options.system_id);
    message.img_idx = static_cast<std::uint16_t>(event.index);
    message.lat = DegE7(event.gps.lat_deg);
    message.lng = DegE7(event.gps.lon_deg);
    message.alt_msl = static_cast<float>(event.gps.height_m);
    message.alt_rel = static_cast<float>(relative);
    // The attitude of the body, as ArduPilot's; the gimbal's is in 285.
    message.roll = static_cast<float>(RadToDeg(motion.state().roll_rad));
    message.pitch = static_cast<float>(RadToDeg(motion.state().pitch_rad));
    message.yaw = static_cast<float>(RadToDeg(motion.state().yaw_rad));
    message.completed_captures = static_cast<std::uint16_t>(event.index + 1);
    return Send(message);
  }
  MavCameraImageCaptured message;
  message.time_boot_ms = event.time_boot_ms;
  message.time_utc = kPowerOnUnixUs + std::uint64_t{event.time_boot_ms} * 1000;
  message.lat = DegE7(event.gps.lat_deg);
  message.lon = DegE7(event.gps.lon_deg);
  message.alt = Millimetres(event.gps.height_m);
  message.relative_alt = Millimetres(relative);
  message.q = CameraQuaternion(false);
  message.image_index = event.index;
  message.capture_result = is_good ? 1 : 0;
  const std::string name = PictureStore::NameOf(event.index);
  if (is_good && options.file_url == "http") {
    SetMavText(picture_url + "/low/" + name, &message.file_url);
  } else if (is_good && options.file_url == "mftp") {
    SetMavText(std::string("mftp://[;comp=100]/low/") + name, &message.file_url);
  }
  if (is_good) sent_reports.push_back(message);
  SendFromCamera(message);
}

// North, east, down from the camera's forward, right, down; w first.
std::array<float, 4> SimulatedAutopilot::Impl::CameraQuaternion(bool relative_to_nose) const {
  const double yaw = relative_to_nose ? gimbal.YawInBody() : gimbal.Heading(motion.state().yaw_rad);
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())) *
      Eigen::Quaterniond(Eigen::AngleAxisd(gimbal.pitch_rad(), Eigen::Vector3d::UnitY()));
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
          static_cast<float>(q.z())};
}

void SimulatedAutopilot::Impl::SendGimbalStatus() {
  MavGimbalManagerStatus message;
  message.time_boot_ms = BootMs();
  message.flags = MavGimbalFlag::kRollLock | MavGimbalFlag::kPitchLock |
                  (gimbal.is_yaw_locked() ? MavGimbalFlag::kYawLock : 0);
  message.gimbal_device_id = 1;
  message.primary_control_sysid = gimbal_owner[0];
  message.primary_control_compid = gimbal_owner[1];
  Send(message);
}

void SimulatedAutopilot::Impl::SendGimbalAttitude() {
  const bool is_locked = gimbal.is_yaw_locked();
  MavGimbalDeviceAttitudeStatus message;
  message.time_boot_ms = BootMs();
  message.flags = static_cast<std::uint16_t>(
      MavGimbalFlag::kRollLock | MavGimbalFlag::kPitchLock |
      (is_locked ? MavGimbalFlag::kYawLock | MavGimbalFlag::kYawInEarthFrame
                 : MavGimbalFlag::kYawInVehicleFrame));
  message.q = CameraQuaternion(!is_locked);
  message.failure_flags = gimbal.is_stuck() ? MavGimbalError::kMotor : 0;
  message.delta_yaw = static_cast<float>(motion.state().yaw_rad);
  message.gimbal_device_id = 1;
  Send(message);
}

void SimulatedAutopilot::Impl::SendGimbalInformation() {
  MavGimbalManagerInformation message;
  message.time_boot_ms = BootMs();
  message.cap_flags = MavGimbalCapability::kHasPitchAxis | MavGimbalCapability::kHasPitchLock |
                      MavGimbalCapability::kHasYawAxis | MavGimbalCapability::kHasYawFollow |
                      MavGimbalCapability::kHasYawLock;
  message.gimbal_device_id = 1;
  message.pitch_min = static_cast<float>(DegToRad(options.gimbal.min_pitch_deg));
  message.pitch_max = static_cast<float>(DegToRad(options.gimbal.max_pitch_deg));
  message.yaw_min = static_cast<float>(-DegToRad(options.gimbal.max_yaw_deg));
  message.yaw_max = static_cast<float>(DegToRad(options.gimbal.max_yaw_deg));
  Send(message);
}

void SimulatedAutopilot::Impl::SendMountStatus() {
  const double pitch = RadToDeg(gimbal.pitch_rad()), yaw = RadToDeg(gimbal.YawInBody());
  if (is_px4) {
    MavMountOrientation message;
    message.time_boot_ms = BootMs();
    message.pitch = static_cast<float>(pitch);
    message.yaw = static_cast<float>(yaw);
    message.yaw_absolute = static_cast<float>(RadToDeg(gimbal.Heading(motion.state().yaw_rad)));
    return Send(message);
  }
  MavMountStatus message;
  message.pointing_a = static_cast<std::int32_t>(std::lround(pitch * 100));
  message.pointing_c = static_cast<std::int32_t>(std::lround(yaw * 100));
  Send(message);
}

void SimulatedAutopilot::Impl::SendCameraInformation() {
  MavCameraInformation message;
  message.time_boot_ms = BootMs();
  const std::string vendor = "colmap_ext", model = "simulated camera";
  std::copy(vendor.begin(), vendor.end(), message.vendor_name.begin());
  std::copy(model.begin(), model.end(), message.model_name.begin());
  message.firmware_version = 1;
  message.focal_length = message.sensor_size_h = message.sensor_size_v =
      std::numeric_limits<float>::quiet_NaN();
  message.flags = MavCameraFlag::kCaptureImage;
  message.gimbal_device_id = 1;
  SendFromCamera(message);
}

void SimulatedAutopilot::Impl::SendCameraSettings() {
  MavCameraSettings message;
  message.time_boot_ms = BootMs();
  message.mode_id = MavCameraMode::kImage;
  message.zoomLevel = message.focusLevel = std::numeric_limits<float>::quiet_NaN();
  SendFromCamera(message);
}

void SimulatedAutopilot::Impl::SendStorage() {
  MavStorageInformation message;
  message.time_boot_ms = BootMs();
  message.storage_id = message.storage_count = 1;
  message.status = MavStorageStatus::kReady;
  message.total_capacity = 32000;
  message.used_capacity = static_cast<float>(captures);
  message.available_capacity = 32000 - static_cast<float>(captures);
  SendFromCamera(message);
}

void SimulatedAutopilot::Impl::SendCaptureStatus() {
  MavCameraCaptureStatus message;
  message.time_boot_ms = BootMs();
  message.image_status = shutter_at_s >= 0 ? 1 : 0;
  message.available_capacity = 32000 - static_cast<float>(captures);
  message.image_count = captures;
  SendFromCamera(message);
}

}  // namespace colmap_ext
