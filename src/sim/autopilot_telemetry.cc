// What the vehicle tells by itself.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/autopilot_impl.h"
#include "sim/telemetry_units.h"

namespace colmap_ext {
namespace {

template <typename Integer>
Integer Centi(double value) {
  const double most = static_cast<double>(std::numeric_limits<Integer>::max());
  return static_cast<Integer>(std::lround(std::clamp(value * 100, -most, most)));
}
double CompassDeg(double yaw_rad) {
  const double deg = RadToDeg(NormalizeAngle(yaw_rad));
  return deg < 0 ? deg + 360 : deg;
}

}  // namespace

void SimulatedAutopilot::Impl::StepTelemetry() {
  for (auto& [id, stream] : streams) {
    if (time_us < stream.second) continue;
    stream.second = time_us + stream.first;
    SendById(id);
  }
}

bool SimulatedAutopilot::Impl::SendById(std::uint32_t id) {
  using Sender = void (Impl::*)();
  static const std::map<std::uint32_t, Sender> kBoth = {
      {MavHeartbeat::kId, &Impl::SendHeartbeat},
      {MavSysStatus::kId, &Impl::SendSysStatus},
      {MavGpsRawInt::kId, &Impl::SendGpsRaw},
      {MavGlobalPositionInt::kId, &Impl::SendGlobalPosition},
      {MavAttitude::kId, &Impl::SendAttitude},
      {MavBatteryStatus::kId, &Impl::SendBattery},
      {MavExtendedSysState::kId, &Impl::SendExtendedState},
      {MavHomePosition::kId, &Impl::SendHome},
      {MavPositionTargetGlobalInt::kId, &Impl::SendTarget},
      {MavAutopilotVersion::kId, &Impl::SendVersion},
      {MavMissionCurrent::kId, &Impl::SendMissionCurrent},
      {MavFenceStatus::kId, &Impl::SendFenceStatus},
      {MavLocalPositionNed::kId, &Impl::SendLocalPosition},
      {MavVfrHud::kId, &Impl::SendVfrHud},
      {MavGimbalManagerInformation::kId, &Impl::SendGimbalInformation},
      {MavGimbalManagerStatus::kId, &Impl::SendGimbalStatus},
      {MavGimbalDeviceAttitudeStatus::kId, &Impl::SendGimbalAttitude},
      {MavMountOrientation::kId, &Impl::SendMountStatus},
      {MavMountStatus::kId, &Impl::SendMountStatus},
      {MavEstimatorStatus::kId, &Impl::SendEstimator},
      {MavEkfStatusReport::kId, &Impl::SendEstimator}};
  const bool is_v2_gimbal = id == MavGimbalManagerInformation::kId ||
                            id == MavGimbalManagerStatus::kId ||
                            id == MavGimbalDeviceAttitudeStatus::kId;
  const bool is_mount = id == MavMountOrientation::kId || id == MavMountStatus::kId;
  if (is_v2_gimbal && options.gimbal_protocol != "v2") return false;
  if (is_mount && options.gimbal_protocol != "mount") return false;
  const bool is_other_stack = id == (is_px4 ? MavEkfStatusReport::kId : MavEstimatorStatus::kId) ||
                              id == (is_px4 ? MavMountStatus::kId : MavMountOrientation::kId);
  const auto sender = kBoth.find(id);
  if (is_other_stack || sender == kBoth.end()) return false;
  (this->*sender->second)();
  return true;
}

void SimulatedAutopilot::Impl::SendHeartbeat() {
  MavHeartbeat message;
  message.type = MavType::kQuadrotor;
  message.autopilot = is_px4 ? MavAutopilot::kPx4 : MavAutopilot::kArduPilot;
  message.custom_mode = Info().custom_mode;
  message.base_mode = MavModeFlag::kCustomModeEnabled;
  if (is_armed) message.base_mode |= MavModeFlag::kSafetyArmed;
  if (mode == FlightMode::kGuided || mode == FlightMode::kMission) {
    message.base_mode |= MavModeFlag::kGuidedEnabled;
  }
  message.system_status =
      failsafe.empty() ? (is_armed ? MavState::kActive : MavState::kStandby) : MavState::kCritical;
  message.mavlink_version = 3;
  Send(message);
  if (!is_px4 || options.camera_protocol != "v2") return;
  MavHeartbeat camera;
  camera.type = MavType::kCamera;
  camera.autopilot = MavAutopilot::kInvalid;
  camera.system_status = MavState::kActive;
  camera.mavlink_version = 3;
  frames.push_back(camera_sender.Next(camera));
}

void SimulatedAutopilot::Impl::SendSysStatus() {
  MavSysStatus message;
  const std::uint32_t present = MavSensor::kGyro | MavSensor::kAccelerometer |
                                MavSensor::kMagnetometer | MavSensor::kPressure | MavSensor::kGps |
                                MavSensor::kGeofence | MavSensor::kAhrs | MavSensor::kBattery |
                                MavSensor::kPrearmCheck;
  message.onboard_control_sensors_present = present;
  message.onboard_control_sensors_enabled = present;
  if (!is_px4 && !is_fence_on) {
    message.onboard_control_sensors_enabled &= ~MavSensor::kGeofence;
  }
  std::uint32_t health = present;
  if (!gps.HasFix()) health &= ~MavSensor::kGps;
  if (!HasPosition()) health &= ~MavSensor::kAhrs;
  if (has_breached) health &= ~MavSensor::kGeofence;
  if (battery_level >= 2) health &= ~MavSensor::kBattery;
  if (!IsPrearmGood()) health &= ~MavSensor::kPrearmCheck;
  message.onboard_control_sensors_health = health;
  message.load = 320;
  message.voltage_battery = static_cast<std::uint16_t>(std::lround(battery.voltage() * 1e3));
  message.current_battery = Centi<std::int16_t>(battery.current());
  message.battery_remaining = static_cast<std::int8_t>(std::floor(battery.percent()));
  Send(message);
}

void SimulatedAutopilot::Impl::SendGpsRaw() {
  MavGpsRawInt message;
  message.time_usec = static_cast<std::uint64_t>(time_us);
  message.fix_type = gps.HasFix() ? MavGpsFixType::k3dFix : MavGpsFixType::kNoFix;
  message.eph = message.epv = message.vel = message.cog = UINT16_MAX;
  message.satellites_visible = static_cast<std::uint8_t>(gps.Satellites());
  if (gps.HasFix()) {
    const GeoPosition fix = Geo(motion.state().position + gps.FixError());
    message.lat = DegE7(fix.lat_deg);
    message.lon = DegE7(fix.lon_deg);
    message.alt = Millimetres(fix.height_m);
    message.alt_ellipsoid = Millimetres(fix.height_m + options.undulation_m);
    message.eph = 80;
    message.epv = 120;
    message.h_acc = static_cast<std::uint32_t>(Millimetres(gps.HorizontalAccuracy()));
    message.v_acc = static_cast<std::uint32_t>(Millimetres(gps.VerticalAccuracy()));
    const Eigen::Vector3d& v = motion.state().velocity;
    message.vel = Centi<std::uint16_t>(v.head<2>().norm());
    message.cog = Centi<std::uint16_t>(CompassDeg(std::atan2(v.x(), v.y())));
  }
  Send(message);
}

void SimulatedAutopilot::Impl::SendGlobalPosition() {
  if (!HasPosition()) return;
  MavGlobalPositionInt message;
  const GeoPosition place = Geo(Estimated());
  const Eigen::Vector3d& v = motion.state().velocity;
  message.time_boot_ms = BootMs();
  message.lat = DegE7(place.lat_deg);
  message.lon = DegE7(place.lon_deg);
  message.alt = Millimetres(place.height_m);
  message.relative_alt = Millimetres(RelativeHeight());
  message.vx = Centi<std::int16_t>(v.y());
  message.vy = Centi<std::int16_t>(v.x());
  message.vz = Centi<std::int16_t>(-v.z());
  message.hdg = Centi<std::uint16_t>(CompassDeg(motion.state().yaw_rad));
  Send(message);
}

void SimulatedAutopilot::Impl::SendLocalPosition() {
  if (!home) return;
  const Eigen::Vector3d offset = Estimated() - *home, v = motion.state().velocity;
  MavLocalPositionNed message;
  message.time_boot_ms = BootMs();
  message.x = static_cast<float>(offset.y());
  message.y = static_cast<float>(offset.x());
  message.z = static_cast<float>(-offset.z());
  message.vx = static_cast<float>(v.y());
  message.vy = static_cast<float>(v.x());
  message.vz = static_cast<float>(-v.z());
  Send(message);
}

void SimulatedAutopilot::Impl::SendVfrHud() {
  const MotionState& state = motion.state();
  MavVfrHud message;
  message.airspeed = static_cast<float>((state.velocity - state.wind).norm());
  message.groundspeed = static_cast<float>(state.velocity.head<2>().norm());
  message.heading = static_cast<std::int16_t>(std::lround(CompassDeg(state.yaw_rad)));
  message.alt = static_cast<float>(Geo(Estimated()).height_m);
  message.climb = static_cast<float>(state.velocity.z());
  Send(message);
}

void SimulatedAutopilot::Impl::SendAttitude() {
  const MotionState& state = motion.state();
  MavAttitude message;
  message.time_boot_ms = BootMs();
  message.roll = static_cast<float>(state.roll_rad);
  message.pitch = static_cast<float>(state.pitch_rad);
  message.yaw = static_cast<float>(state.yaw_rad);
  message.yawspeed = static_cast<float>(state.yaw_rate_rad_s);
  Send(message);
}

void SimulatedAutopilot::Impl::SendBattery() {
  MavBatteryStatus message;
  message.type = 3;                 // lithium ion
  message.temperature = INT16_MAX;  // unknown
  message.voltages.fill(UINT16_MAX);
  for (std::size_t cell = 0; cell < 4; ++cell) {
    message.voltages[cell] = static_cast<std::uint16_t>(std::lround(battery.voltage() * 250));
  }
  message.current_battery = Centi<std::int16_t>(battery.current());
  message.current_consumed =
      static_cast<std::int32_t>(std::lround(battery.consumed_wh() / 14.8 * 1e3));
  message.energy_consumed = static_cast<std::int32_t>(std::lround(battery.consumed_wh() * 36));
  message.battery_remaining = static_cast<std::int8_t>(std::floor(battery.percent()));
  message.time_remaining = static_cast<std::int32_t>(battery.TimeLeft());
  message.charge_state = static_cast<MavBatteryChargeState>(1 + battery_level);
  Send(message);
}

void SimulatedAutopilot::Impl::SendEstimator() {
  using Flag = MavEstimatorFlag;
  std::uint16_t flags = Flag::kAttitude | Flag::kVelocityVertical | Flag::kPositionVerticalAbsolute;
  if (HasPosition()) {
    flags |= Flag::kVelocityHorizontal | Flag::kPositionHorizontalRelative |
             Flag::kPositionHorizontalAbsolute | Flag::kPredictedPositionHorizontalRelative |
             Flag::kPredictedPositionHorizontalAbsolute;
  } else {
    flags |= Flag::kConstantPositionMode;
  }
  if (gps.IsGlitching()) flags |= is_px4 ? Flag::kPx4GpsGlitch : Flag::kArduPilotGpsGlitching;
  const float ratio = gps.IsGlitching() ? 2.5F : 0.08F;
  if (is_px4) {
    MavEstimatorStatus message;
    message.time_usec = static_cast<std::uint64_t>(time_us);
    message.flags = flags;
    message.pos_horiz_ratio = ratio;
    message.pos_horiz_accuracy = static_cast<float>(gps.HorizontalAccuracy());
    message.pos_vert_accuracy = static_cast<float>(gps.VerticalAccuracy());
    return Send(message);
  }
  MavEkfStatusReport message;
  message.flags = flags;
  message.pos_horiz_variance = ratio;
  Send(message);
}

void SimulatedAutopilot::Impl::SendHome() {
  if (!home) return;
  const GeoPosition place = Geo(*home);
  MavHomePosition message;
  message.latitude = DegE7(place.lat_deg);
  message.longitude = DegE7(place.lon_deg);
  message.altitude = Millimetres(place.height_m);
  message.q = {1, 0, 0, 0};
  message.time_usec = static_cast<std::uint64_t>(time_us);
  Send(message);
}

void SimulatedAutopilot::Impl::SendExtendedState() {
  const bool lands = mode == FlightMode::kLand ||
                     (mode == FlightMode::kReturn && return_phase == ReturnPhase::kLand);
  MavExtendedSysState message;
  message.landed_state = is_landed       ? MavLandedState::kOnGround
                         : is_taking_off ? MavLandedState::kTakeoff
                         : lands         ? MavLandedState::kLanding
                                         : MavLandedState::kInAir;
  Send(message);
}

void SimulatedAutopilot::Impl::SendTarget() {
  if (!is_armed || !HasPosition()) return;
  const GeoPosition place = Geo(goal);
  MavPositionTargetGlobalInt message;
  message.time_boot_ms = BootMs();
  message.coordinate_frame = MavCoordinateFrame::kGlobal;
  message.type_mask =
      MavTargetIgnore::kVelocity | MavTargetIgnore::kAcceleration | MavTargetIgnore::kYawRate;
  message.lat_int = DegE7(place.lat_deg);
  message.lon_int = DegE7(place.lon_deg);
  message.alt = static_cast<float>(place.height_m);
  message.yaw = static_cast<float>(goal_yaw);
  Send(message);
}

void SimulatedAutopilot::Impl::SendVersion() {
  MavAutopilotVersion message;
  message.capabilities =
      MavCapability::kMissionInt | MavCapability::kCommandInt | MavCapability::kMavlink2 |
      MavCapability::kMissionFence | MavCapability::kMissionRally | MavCapability::kFtp |
      MavCapability::kSetPositionTargetGlobalInt |
      (is_px4 ? MavCapability::kParamEncodeBytewise : MavCapability::kParamEncodeCCast);
  // major, minor, patch, release type 255: official.
  message.flight_sw_version = is_px4 ? 0x010F00FF : 0x040700FF;
  message.uid = options.seed;
  message.vendor_id = 0;
  Send(message);
}

void SimulatedAutopilot::Impl::SendFenceStatus() {
  MavFenceStatus message;
  message.breach_status = has_breached ? 1 : 0;
  message.breach_count = static_cast<std::uint16_t>(breaches);
  message.breach_type = has_breached ? MavFenceBreach::kBoundary : MavFenceBreach::kNone;
  message.breach_time = breach_ms;
  Send(message);
}

void SimulatedAutopilot::Impl::SendMissionCurrent() {
  MavMissionCurrent message;
  message.total = static_cast<std::uint16_t>(missions.Items(MavMissionType::kMission).size());
  message.seq = static_cast<std::uint16_t>(std::max(0, mission_item));
  message.mission_state = message.total == 0             ? MavMissionState::kNoMission
                          : is_mission_done              ? MavMissionState::kComplete
                          : mission_item < 0             ? MavMissionState::kNotStarted
                          : mode == FlightMode::kMission ? MavMissionState::kActive
                                                         : MavMissionState::kPaused;
  Send(message);
}

}  // namespace colmap_ext
