// Modes, arming, take-off, return, landing.
#include <algorithm>
#include <cmath>

#include "sim/autopilot_impl.h"

namespace colmap_ext {
namespace {

constexpr double kReached_m = 0.5;
constexpr double kSlow_m_s = 0.3;
constexpr double kLandFromAbove_m = 10;  // above home: faster descent until here

std::uint32_t Px4(Px4MainMode main, Px4AutoMode sub = Px4AutoMode::kNone) {
  return ToCustomMode({main, sub});
}

std::uint32_t Copter(ArduCopterMode mode) { return static_cast<std::uint32_t>(mode); }

}  // namespace

const std::vector<FlightModeInfo>& FlightModesOf(AutopilotPersonality personality) {
  using Mode = FlightMode;
  static const std::vector<FlightModeInfo> px4 = {
      {Mode::kStabilize, "STABILIZED", Px4(Px4MainMode::kStabilized), false},
      {Mode::kAltitude, "ALTCTL", Px4(Px4MainMode::kAltitude), false},
      {Mode::kPilot, "POSCTL", Px4(Px4MainMode::kPosition), true},
      {Mode::kTakeoff, "TAKEOFF", Px4(Px4MainMode::kAuto, Px4AutoMode::kTakeoff), true},
      {Mode::kGuided, "HOLD", Px4(Px4MainMode::kAuto, Px4AutoMode::kHold), true},
      {Mode::kMission, "MISSION", Px4(Px4MainMode::kAuto, Px4AutoMode::kMission), true},
      {Mode::kReturn, "RTL", Px4(Px4MainMode::kAuto, Px4AutoMode::kReturn), true},
      {Mode::kLand, "LAND", Px4(Px4MainMode::kAuto, Px4AutoMode::kLand), false}};
  static const std::vector<FlightModeInfo> copter = {
      {Mode::kStabilize, "STABILIZE", Copter(ArduCopterMode::kStabilize), false},
      {Mode::kAltitude, "ALT_HOLD", Copter(ArduCopterMode::kAltHold), false},
      {Mode::kMission, "AUTO", Copter(ArduCopterMode::kAuto), true},
      {Mode::kGuided, "GUIDED", Copter(ArduCopterMode::kGuided), true},
      {Mode::kPilot, "LOITER", Copter(ArduCopterMode::kLoiter), true},
      {Mode::kReturn, "RTL", Copter(ArduCopterMode::kRtl), true},
      {Mode::kLand, "LAND", Copter(ArduCopterMode::kLand), false},
      {Mode::kPosHold, "POSHOLD", Copter(ArduCopterMode::kPosHold), true},
      {Mode::kBrake, "BRAKE", Copter(ArduCopterMode::kBrake), true},
      {Mode::kSmartReturn, "SMART_RTL", Copter(ArduCopterMode::kSmartRtl), true}};
  return personality == AutopilotPersonality::kPx4 ? px4 : copter;
}

const FlightModeInfo& SimulatedAutopilot::Impl::Info() const {
  const auto& modes = FlightModesOf(options.personality);
  return *std::ranges::find(modes, mode, &FlightModeInfo::mode);
}

// ArduPilot's estimator takes 16 s more than its pre-arm bit says (FLIGHT_NOTES).
bool SimulatedAutopilot::Impl::HasPosition() const {
  const double ready = options.estimator_ready_s + (is_px4 ? 0 : 16);
  return gps.HasFix() && Now() >= ready;
}

bool SimulatedAutopilot::Impl::IsPrearmGood() const {
  const bool is_ready = Now() >= options.prearm_ready_s && gps.HasFix() && battery.percent() > 10;
  return is_px4 ? is_ready && HasPosition() : is_ready;
}

bool SimulatedAutopilot::Impl::CanArm() const {
  return IsPrearmGood() && HasPosition() && home.has_value() && !gps.IsGlitching() && !has_crashed;
}

bool SimulatedAutopilot::Impl::EnterMode(FlightMode next) {
  const auto& modes = FlightModesOf(options.personality);
  const auto info = std::ranges::find(modes, next, &FlightModeInfo::mode);
  if (info == modes.end()) return false;
  if (info->needs_position && !HasPosition()) {
    Say(MavSeverity::kWarning,
        is_px4 ? "Mode change rejected: no position" : "Mode change failed: requires position");
    return false;
  }
  if (next == FlightMode::kMission && !StartMission(is_px4 ? 0 : 1)) return false;
  if (next == mode) return true;
  mode = next;
  is_taking_off = next == FlightMode::kTakeoff && is_taking_off;
  // Stop ahead: where it can stop from its present speed.
  const Eigen::Vector3d velocity = motion.state().velocity;
  const double ahead_s = velocity.norm() / motion.options().max_acceleration_m_s2;
  SetGoal(Estimated() + velocity * ahead_s);
  yaw_follows_travel = false;
  goal_yaw = motion.state().yaw_rad;
  return_phase = ReturnPhase::kClimb;
  const double above_home =
      is_px4 ? parameters.Get("RTL_RETURN_ALT") : parameters.Get("RTL_ALT") * 0.01;
  return_z = std::max(Estimated().z(), (home ? home->z() : Estimated().z()) + above_home);
  if (!is_px4) SendHeartbeat();  // PX4 leaves it to the next one, up to a second later
  return true;
}

void SimulatedAutopilot::Impl::SetGoal(const Eigen::Vector3d& next) {
  goal = next;
  speed_m_s = is_px4 ? parameters.Get("MPC_XY_CRUISE") : parameters.Get("WPNAV_SPEED") * 0.01;
}

MavResult SimulatedAutopilot::Impl::Arm(bool wants_armed, bool force) {
  if (!wants_armed) {
    if (is_armed && !is_landed && !force)
      return is_px4 ? MavResult::kTemporarilyRejected : MavResult::kFailed;
    Disarm();
    return MavResult::kAccepted;
  }
  if (is_armed) return MavResult::kAccepted;
  const bool is_mode_fine = is_px4 || mode == FlightMode::kGuided || mode == FlightMode::kPilot ||
                            mode == FlightMode::kStabilize || mode == FlightMode::kAltitude ||
                            mode == FlightMode::kMission;
  if (!CanArm() || !is_mode_fine) {
    if (is_px4) {
      Say(MavSeverity::kCritical, "Arming denied: resolve system health failures first");
      return MavResult::kTemporarilyRejected;
    }
    Say(MavSeverity::kCritical,
        is_mode_fine ? "Arm: Need Position Estimate" : "Arm: Mode not armable");
    return MavResult::kFailed;
  }
  is_armed = true;
  armed_at_s = Now();
  landed_at_s = -1;
  home = Estimated();
  SetGoal(Estimated());
  goal_yaw = motion.state().yaw_rad;
  failsafe.clear();
  has_breached = has_lost_position = false;
  return MavResult::kAccepted;
}

void SimulatedAutopilot::Impl::Disarm() {
  is_armed = false;
  is_taking_off = false;
  touched_at_s = -1;
}

MavResult SimulatedAutopilot::Impl::Takeoff(double goal_z) {
  if (is_px4) {
    if (!is_landed) return MavResult::kTemporarilyRejected;
    if (mode != FlightMode::kTakeoff && !EnterMode(FlightMode::kTakeoff)) {
      return MavResult::kTemporarilyRejected;
    }
  } else if (mode != FlightMode::kGuided || !is_armed || !is_landed) {
    return MavResult::kFailed;
  }
  SetGoal({Estimated().x(), Estimated().y(), std::max(goal_z, Estimated().z() + 0.5)});
  is_taking_off = true;
  return MavResult::kAccepted;
}

bool SimulatedAutopilot::Impl::IsInsideFence(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d from_home = position - home.value_or(position);
  if (is_px4) {
    if (parameters.GetInt("GF_ACTION") == 0) return true;
    const double far = parameters.Get("GF_MAX_HOR_DIST"), high = parameters.Get("GF_MAX_VER_DIST");
    if (far > 0 && from_home.head<2>().norm() > far) return false;
    if (high > 0 && from_home.z() > high) return false;
    return fence.Contains(position.head<2>(), true);
  }
  if (!is_fence_on) return true;
  const int types = parameters.GetInt("FENCE_TYPE");
  if ((types & 1) != 0 && from_home.z() > parameters.Get("FENCE_ALT_MAX")) return false;
  if ((types & 2) != 0 && from_home.head<2>().norm() > parameters.Get("FENCE_RADIUS")) return false;
  return (types & 4) == 0 || fence.Contains(position.head<2>(), false);
}

void SimulatedAutopilot::Impl::StepFlight() {
  if (mode == FlightMode::kMission) StepMission();
  MotionTarget target;
  target.position = Estimated();
  target.yaw_rad = motion.state().yaw_rad;
  target.motors = is_armed;
  if (is_armed && battery.percent() <= 0) target.motors = false;
  if (is_armed) {
    const bool lands = mode == FlightMode::kLand;
    const bool returns = mode == FlightMode::kReturn || mode == FlightMode::kSmartReturn;
    if (lands) {
      target = LandTarget();
    } else if (returns) {
      target = ReturnTarget();
    } else if (is_taking_off || !is_landed) {
      target = mode == FlightMode::kMission ? MissionTarget() : GoalTarget();
    } else {
      target.climb_rate_m_s = 0;  // on the ground, idling
    }
    target.motors = battery.percent() > 0;
  }
  motion.SetTarget(target);

  if (!is_taking_off || is_landed) return;
  const bool is_up = std::abs(Estimated().z() - goal.z()) < kReached_m &&
                     motion.state().velocity.norm() < kSlow_m_s;
  if (!is_up) return;
  is_taking_off = false;
  if (mode != FlightMode::kTakeoff) return;
  const Eigen::Vector3d reached = goal;
  EnterMode(FlightMode::kGuided);
  SetGoal(reached);
}

MotionTarget SimulatedAutopilot::Impl::GoalTarget() const {
  MotionTarget target;
  target.motors = true;
  target.position = goal;
  target.yaw_rad = goal_yaw;
  target.speed_m_s = speed_m_s;
  target.climb_m_s =
      is_px4 ? parameters.Get("MPC_Z_VEL_MAX_UP") : parameters.Get("WPNAV_SPEED_UP") * 0.01;
  target.descent_m_s =
      is_px4 ? parameters.Get("MPC_Z_VEL_MAX_DN") : parameters.Get("WPNAV_SPEED_DN") * 0.01;
  const Eigen::Vector2d travel = (goal - Estimated()).head<2>();
  if (yaw_follows_travel && travel.norm() > 2) {
    target.yaw_rad = std::atan2(travel.x(), travel.y());
  } else if (yaw_follows_travel) {
    target.yaw_rad = motion.target().yaw_rad;
  }
  return target;
}

MotionTarget SimulatedAutopilot::Impl::LandTarget() const {
  MotionTarget target = GoalTarget();
  const double slow =
      is_px4 ? parameters.Get("MPC_LAND_SPEED") : parameters.Get("LAND_SPEED") * 0.01;
  target.climb_rate_m_s = RelativeHeight() > kLandFromAbove_m ? -target.descent_m_s : -slow;
  return target;
}

MotionTarget SimulatedAutopilot::Impl::ReturnTarget() {
  const Eigen::Vector3d now = Estimated();
  const Eigen::Vector3d place = home.value_or(now);
  if (is_landed && !is_taking_off) {
    MotionTarget idle = GoalTarget();
    idle.position = now;
    idle.climb_rate_m_s = 0;
    return idle;
  }
  if (return_phase == ReturnPhase::kClimb) {
    goal.z() = return_z;
    if (std::abs(now.z() - return_z) < kReached_m) return_phase = ReturnPhase::kTravel;
  } else if (return_phase == ReturnPhase::kTravel) {
    goal = {place.x(), place.y(), return_z};
    if ((now - goal).norm() < 1 && motion.state().velocity.norm() < kSlow_m_s) {
      return_phase = ReturnPhase::kWait;
      return_wait_until_s = Now() + (is_px4 ? std::max(0.0, parameters.Get("RTL_LAND_DELAY"))
                                            : parameters.Get("RTL_LOIT_TIME") * 1e-3);
    }
  } else if (return_phase == ReturnPhase::kWait && Now() >= return_wait_until_s) {
    return_phase = ReturnPhase::kLand;
  }
  return return_phase == ReturnPhase::kLand ? LandTarget() : GoalTarget();
}

void SimulatedAutopilot::Impl::StepLanded() {
  const MotionState& state = motion.state();
  if (state.impact_speed_m_s > 3 && !has_crashed) {
    has_crashed = true;
    Say(MavSeverity::kEmergency, is_px4 ? "Crash detected" : "Crash: Disarming");
    Disarm();
  }
  if (!state.on_ground) {
    is_landed = false;
    touched_at_s = -1;
    return;
  }
  if (is_landed && !is_armed) return;
  if (touched_at_s < 0) touched_at_s = Now();
  if (!is_landed && Now() - touched_at_s > 1) {
    is_landed = true;
    landed_at_s = Now();
  }
  if (!is_armed || !is_landed || is_taking_off) return;
  const double wait = landed_at_s < 0 ? parameters.Get(is_px4 ? "COM_DISARM_PRFLT" : "DISARM_DELAY")
                                      : (is_px4 ? parameters.Get("COM_DISARM_LAND") : 0.5);
  const double since = landed_at_s < 0 ? armed_at_s : landed_at_s;
  if (wait > 0 && Now() - since > wait) {
    Disarm();
    Say(MavSeverity::kInfo, is_px4 ? "Disarmed by landing" : "Disarming motors");
  }
}

}  // namespace colmap_ext
