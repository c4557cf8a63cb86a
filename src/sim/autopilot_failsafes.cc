// What the vehicle does by itself when something goes wrong.
#include <cmath>

#include "sim/autopilot_impl.h"

namespace colmap_ext {
namespace {

constexpr double kPositionLossAllowed_s = 5;

}  // namespace

void SimulatedAutopilot::Impl::StepFailsafes() {
  if (time_us < next_failsafe_us) return;
  next_failsafe_us = time_us + 100'000;
  StepLinkFailsafe();
  StepBatteryFailsafe();
  StepFenceFailsafe();
  StepPositionFailsafe();
}

// Acts in the air only, and never raises a vehicle out of its landing.
void SimulatedAutopilot::Impl::ActOn(const std::string& name, FlightMode next) {
  const bool is_landing = mode == FlightMode::kLand;
  if (!is_armed || is_landed || is_landing) return;
  failsafe = name;
  EnterMode(next);
}

// The mode is not restored when the ground station comes back.
void SimulatedAutopilot::Impl::StepLinkFailsafe() {
  if (gcs_heard_s < 0) return;  // never had one
  const double limit = is_px4 ? parameters.Get("COM_DL_LOSS_T") : parameters.Get("FS_GCS_TIMEOUT");
  const bool is_lost = Now() - gcs_heard_s > limit;
  const bool has_just_been_lost = is_lost && !has_lost_link;
  has_lost_link = is_lost;
  if (!has_just_been_lost) return;
  if (is_px4) {
    const int action = parameters.GetInt("NAV_DLL_ACT");
    if (action == 0) return;
    Say(MavSeverity::kCritical, "Failsafe: connection to ground control lost");
    ActOn("link", action == 1   ? FlightMode::kGuided
                  : action == 3 ? FlightMode::kLand
                                : FlightMode::kReturn);
  } else if (const int action = parameters.GetInt("FS_GCS_ENABLE"); action != 0) {
    Say(MavSeverity::kWarning, "GCS Failsafe");
    ActOn("link", action == 5 ? FlightMode::kLand : FlightMode::kReturn);
  }
}

void SimulatedAutopilot::Impl::StepBatteryFailsafe() {
  int level = 0;
  if (is_px4) {
    const double part = battery.percent() / 100;
    for (const char* name : {"BAT_LOW_THR", "BAT_CRIT_THR", "BAT_EMERGEN_THR"}) {
      level += part < parameters.Get(name) ? 1 : 0;
    }
  } else {
    const double left_mah = battery.percent() / 100 * parameters.Get("BATT_CAPACITY");
    level += left_mah < parameters.Get("BATT_LOW_MAH") ? 1 : 0;
    level += left_mah < parameters.Get("BATT_CRT_MAH") ? 1 : 0;
  }
  if (level <= battery_level) {
    battery_level = level;
    return;
  }
  battery_level = level;
  Say(MavSeverity::kWarning, is_px4
                                 ? (level == 1 ? "Low battery level!" : "Critical battery level!")
                                 : "Battery 1 is low");
  if (is_px4) {
    const int action = parameters.GetInt("COM_LOW_BAT_ACT");
    if (action == 2 && level >= 2) ActOn("battery", FlightMode::kLand);
    if (action == 3 && level == 2) ActOn("battery", FlightMode::kReturn);
    if (action == 3 && level == 3) ActOn("battery", FlightMode::kLand);
  } else {
    const int action = parameters.GetInt(level == 1 ? "BATT_FS_LOW_ACT" : "BATT_FS_CRT_ACT");
    if (action == 1) ActOn("battery", FlightMode::kLand);
    if (action >= 2) ActOn("battery", FlightMode::kReturn);
  }
}

void SimulatedAutopilot::Impl::StepFenceFailsafe() {
  const bool is_outside = is_armed && !is_landed && !IsInsideFence(Estimated());
  const bool is_new = is_outside && !has_breached;
  has_breached = is_outside;
  if (!is_new) return;
  ++breaches;
  breach_ms = BootMs();
  Say(MavSeverity::kWarning, is_px4 ? "Geofence violation" : "Fence Breached");
  SendFenceStatus();
  const int action = parameters.GetInt(is_px4 ? "GF_ACTION" : "FENCE_ACTION");
  if (is_px4) {
    if (action == 2) ActOn("fence", FlightMode::kGuided);
    if (action == 3) ActOn("fence", FlightMode::kReturn);
    if (action == 5) ActOn("fence", FlightMode::kLand);
    if (action == 2 && mode == FlightMode::kGuided) SetGoal(Estimated());
  } else {
    if (action == 1) ActOn("fence", FlightMode::kReturn);
    if (action == 2) ActOn("fence", FlightMode::kLand);
    if (action == 4) ActOn("fence", FlightMode::kBrake);
  }
}

void SimulatedAutopilot::Impl::StepPositionFailsafe() {
  if (HasPosition()) {
    position_lost_at_s = -1;
    has_lost_position = false;
    return;
  }
  if (position_lost_at_s < 0) position_lost_at_s = Now();
  if (has_lost_position || Now() - position_lost_at_s < kPositionLossAllowed_s) return;
  has_lost_position = true;
  if (!is_armed || is_landed) return;
  Say(MavSeverity::kCritical, is_px4 ? "Failsafe: no position, landing" : "EKF Failsafe");
  ActOn("position", FlightMode::kLand);
}

}  // namespace colmap_ext
