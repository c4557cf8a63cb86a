#include "flight/telemetry.h"

#include <array>
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/utc_time.h"
#include "flight/autopilot_dialect.h"

namespace colmap_ext {
namespace {

constexpr double kDegE7 = 1e-7;
constexpr double kMilli = 1e-3;
constexpr std::uint16_t kUnknownHeading = 0xFFFF;

GeoPosition Geo(std::int32_t lat, std::int32_t lon, std::int32_t height_mm) {
  return {lat * kDegE7, lon * kDegE7, height_mm * kMilli};
}

void Take(const MavHeartbeat& message, double now_s, VehicleState* vehicle) {
  if (message.autopilot == MavAutopilot::kPx4) vehicle->stack = AutopilotStack::kPx4;
  if (message.autopilot == MavAutopilot::kArduPilot) vehicle->stack = AutopilotStack::kArduPilot;
  vehicle->is_armed = (message.base_mode & MavModeFlag::kSafetyArmed) != 0;
  vehicle->mode = ModeOf(vehicle->stack, message.custom_mode);
  vehicle->mode_name = ModeName(vehicle->stack, message.custom_mode);
  vehicle->mode_heard_s = now_s;
}

void Take(const MavGlobalPositionInt& message, double now_s, VehicleState* vehicle) {
  vehicle->position = Geo(message.lat, message.lon, message.alt);
  vehicle->position_heard_s = now_s;
  vehicle->relative_height_m = message.relative_alt * kMilli;
  vehicle->velocity_in_enu = Eigen::Vector3d(message.vy, message.vx, -message.vz) * 0.01;
  if (message.hdg != kUnknownHeading)
    vehicle->yaw_rad = NormalizeAngle(DegToRad(message.hdg * 0.01));
}

void Take(const MavAttitude& message, double, VehicleState* vehicle) {
  vehicle->roll_rad = message.roll;
  vehicle->pitch_rad = message.pitch;
}

void Take(const MavGpsRawInt& message, double, VehicleState* vehicle) {
  const auto sigma = [](std::uint32_t mm) {
    return mm > 0 ? std::optional<double>(mm * kMilli) : std::nullopt;
  };
  vehicle->gps_fix = static_cast<int>(message.fix_type);
  vehicle->satellites = message.satellites_visible == 255 ? 0 : message.satellites_visible;
  vehicle->sigma_horizontal_m = sigma(message.h_acc);
  vehicle->sigma_vertical_m = sigma(message.v_acc);
  if (message.alt_ellipsoid != 0) vehicle->ellipsoid_height_m = message.alt_ellipsoid * kMilli;
}

void Take(const MavSysStatus& message, double, VehicleState* vehicle) {
  if ((message.onboard_control_sensors_present & MavSensor::kPrearmCheck) != 0) {
    vehicle->is_prearm_good =
        (message.onboard_control_sensors_health & MavSensor::kPrearmCheck) != 0;
  }
  if (message.battery_remaining >= 0) vehicle->battery_percent = message.battery_remaining;
}

void Take(const MavBatteryStatus& message, double, VehicleState* vehicle) {
  if (message.id == 0 && message.battery_remaining >= 0) {
    vehicle->battery_percent = message.battery_remaining;
  }
}

void Take(const MavExtendedSysState& message, double, VehicleState* vehicle) {
  switch (message.landed_state) {
    case MavLandedState::kOnGround:
      vehicle->landed = LandedState::kOnGround;
      return;
    case MavLandedState::kInAir:
      vehicle->landed = LandedState::kInAir;
      return;
    case MavLandedState::kTakeoff:
      vehicle->landed = LandedState::kTakingOff;
      return;
    case MavLandedState::kLanding:
      vehicle->landed = LandedState::kLanding;
      return;
    default:
      vehicle->landed = LandedState::kUnknown;
  }
}

void Take(const MavHomePosition& message, double, VehicleState* vehicle) {
  vehicle->home = Geo(message.latitude, message.longitude, message.altitude);
}

void Take(const MavPositionTargetGlobalInt& message, double, VehicleState* vehicle) {
  const bool has_place = (message.type_mask & MavTargetIgnore::kPosition) == 0 &&
                         (message.lat_int != 0 || message.lon_int != 0);
  const bool is_amsl = message.coordinate_frame == MavCoordinateFrame::kGlobal ||
                       message.coordinate_frame == MavCoordinateFrame::kGlobalInt;
  if (!has_place || !is_amsl) {
    vehicle->target.reset();
    return;
  }
  vehicle->target = {message.lat_int * kDegE7, message.lon_int * kDegE7, message.alt};
}

void Take(const MavFenceStatus& message, double, VehicleState* vehicle) {
  vehicle->is_fence_breached = message.breach_status != 0;
}

void Take(const MavEkfStatusReport& message, double, VehicleState* vehicle) {
  constexpr int kBad = MavEstimatorFlag::kConstantPositionMode |
                       MavEstimatorFlag::kArduPilotUninitialized |
                       MavEstimatorFlag::kArduPilotGpsGlitching;
  const int flags = message.flags;
  vehicle->is_estimate_good =
      (flags & MavEstimatorFlag::kPositionHorizontalAbsolute) != 0 && (flags & kBad) == 0;
}

void Take(const MavEstimatorStatus& message, double, VehicleState* vehicle) {
  const int flags = static_cast<int>(message.flags);
  vehicle->is_estimate_good = (flags & MavEstimatorFlag::kPositionHorizontalAbsolute) != 0 &&
                              (flags & MavEstimatorFlag::kPx4GpsGlitch) == 0;
}

void Take(const MavGimbalDeviceAttitudeStatus& message, double now_s, VehicleState* vehicle) {
  const std::optional<Eigen::Quaterniond> cam_from_enu = CamFromEnu(message.q);
  if (!cam_from_enu) return;
  const ViewDirection direction = ViewDirectionOf({*cam_from_enu, Eigen::Vector3d::Zero()});
  constexpr std::uint32_t kEarth = MavGimbalFlag::kYawInEarthFrame | MavGimbalFlag::kYawLock;
  const bool is_from_north = (message.flags & kEarth) != 0;
  vehicle->gimbal =
      GimbalState{now_s, direction.pitch_rad,
                  NormalizeAngle(direction.yaw_rad + (is_from_north ? 0 : vehicle->yaw_rad))};
}

// The older reports count only where the newer ones do not come.
bool HasNewerGimbal(const VehicleState& vehicle, double now_s) {
  return vehicle.gimbal && vehicle.gimbal->is_v2 && now_s - vehicle.gimbal->heard_s < 3;
}

void Take(const MavMountOrientation& message, double now_s, VehicleState* vehicle) {
  if (HasNewerGimbal(*vehicle, now_s)) return;
  vehicle->gimbal = GimbalState{now_s, DegToRad(message.pitch),
                                NormalizeAngle(vehicle->yaw_rad + DegToRad(message.yaw)), false};
}

void Take(const MavMountStatus& message, double now_s, VehicleState* vehicle) {
  if (HasNewerGimbal(*vehicle, now_s)) return;
  vehicle->gimbal =
      GimbalState{now_s, DegToRad(message.pointing_a * 0.01),
                  NormalizeAngle(vehicle->yaw_rad + DegToRad(message.pointing_c * 0.01)), false};
}

template <typename Message>
bool TakeIf(const MavFrame& frame, double now_s, VehicleState* vehicle) {
  const auto message = UnpackMav<Message>(frame);
  if (message) Take(*message, now_s, vehicle);
  return message.has_value();
}

CaptureReport CommonReport(const VehicleState& vehicle) {
  CaptureReport report;
  report.record.sigma_horizontal_m = vehicle.sigma_horizontal_m;
  report.record.sigma_vertical_m = vehicle.sigma_vertical_m;
  report.ellipsoid_height_m = vehicle.ellipsoid_height_m;
  report.body_yaw_rad = vehicle.yaw_rad;
  report.gps_fix = vehicle.gps_fix;
  return report;
}

CaptureReport FromImageCaptured(const MavCameraImageCaptured& message,
                                const VehicleState& vehicle) {
  CaptureReport report = CommonReport(vehicle);
  report.record.index = message.image_index;
  report.record.time = IsoTime(message.time_utc);
  report.record.position = Geo(message.lat, message.lon, message.alt);
  report.record.cam_from_enu = CamFromEnu(message.q);
  report.relative_height_m = message.relative_alt * kMilli;
  report.succeeded = message.capture_result == 1;
  report.file_url = MavText(message.file_url);
  return report;
}

CaptureReport FromFeedback(const MavCameraFeedback& message, const VehicleState& vehicle) {
  CaptureReport report = CommonReport(vehicle);
  report.record.index = message.img_idx;
  report.record.time = IsoTime(message.time_usec);
  report.record.position = {message.lat * kDegE7, message.lng * kDegE7,
                            static_cast<double>(message.alt_msl)};
  // Its angles are the vehicle's, not the camera's.
  if (vehicle.gimbal) {
    const ViewDirection direction = {vehicle.gimbal->yaw_rad, vehicle.gimbal->pitch_rad};
    report.record.cam_from_enu = CamFromWorld(Eigen::Vector3d::Zero(), direction).rotation;
  }
  report.relative_height_m = message.alt_rel;
  return report;
}

}  // namespace

bool UpdateVehicle(const MavFrame& frame, double now_s, VehicleState* vehicle) {
  return TakeIf<MavHeartbeat>(frame, now_s, vehicle) ||
         TakeIf<MavGlobalPositionInt>(frame, now_s, vehicle) ||
         TakeIf<MavAttitude>(frame, now_s, vehicle) ||
         TakeIf<MavGpsRawInt>(frame, now_s, vehicle) ||
         TakeIf<MavSysStatus>(frame, now_s, vehicle) ||
         TakeIf<MavBatteryStatus>(frame, now_s, vehicle) ||
         TakeIf<MavExtendedSysState>(frame, now_s, vehicle) ||
         TakeIf<MavHomePosition>(frame, now_s, vehicle) ||
         TakeIf<MavPositionTargetGlobalInt>(frame, now_s, vehicle) ||
         TakeIf<MavFenceStatus>(frame, now_s, vehicle) ||
         TakeIf<MavEkfStatusReport>(frame, now_s, vehicle) ||
         TakeIf<MavEstimatorStatus>(frame, now_s, vehicle) ||
         TakeIf<MavGimbalDeviceAttitudeStatus>(frame, now_s, vehicle) ||
         TakeIf<MavMountOrientation>(frame, now_s, vehicle) ||
         TakeIf<MavMountStatus>(frame, now_s, vehicle);
}

std::optional<CaptureReport> ReadCapture(const MavFrame& frame, const VehicleState& vehicle) {
  if (const auto message = UnpackMav<MavCameraImageCaptured>(frame)) {
    return FromImageCaptured(*message, vehicle);
  }
  // PX4's driver says both; 263 says more.
  if (vehicle.stack != AutopilotStack::kArduPilot) return std::nullopt;
  if (const auto message = UnpackMav<MavCameraFeedback>(frame)) {
    return FromFeedback(*message, vehicle);
  }
  return std::nullopt;
}

std::optional<Eigen::Quaterniond> CamFromEnu(const std::array<float, 4>& q) {
  const Eigen::Quaterniond ned_from_frd(q[0], q[1], q[2], q[3]);
  if (!(std::abs(ned_from_frd.norm() - 1) < 0.01)) return std::nullopt;
  Eigen::Matrix3d frd_from_cam, enu_from_ned;
  frd_from_cam << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  enu_from_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Eigen::Matrix3d enu_from_cam =
      enu_from_ned * ned_from_frd.normalized().toRotationMatrix() * frd_from_cam;
  return Eigen::Quaterniond(enu_from_cam.transpose()).normalized();
}

std::string IsoTime(std::uint64_t microseconds) {
  return microseconds == 0 ? "" : UtcText(microseconds, 6);
}

}  // namespace colmap_ext
