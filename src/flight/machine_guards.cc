// What ends a normal course: link, arming, mode, position, battery.
#include <algorithm>
#include <cmath>

#include "flight/machine_impl.h"

namespace colmap_ext {
namespace {

constexpr double kPositionTimeoutS = 3;    // without a position while messages come
constexpr double kBadPositionS = 1;        // shorter glitches are the estimator's
constexpr double kGoodPositionAgainS = 5;  // then the flight goes on
constexpr double kModeLagS = 2.5;          // heartbeats tell the mode, once a second
constexpr double kPhotoEnergyS = 8;        // settling, aiming, capture: for the energy of a view

}  // namespace

bool MachineImpl::GuardLink() {
  const bool is_heard = now_s - vehicle_.heard_s <= options.link_timeout_s;
  if (state == FlightState::kDisconnected) return !is_heard;
  if (is_heard) {
    if (state != FlightState::kLinkLost) return false;
    ReturnFromLinkLoss();
    if (IsWaitingForPicture()) AskCamera();
    return true;
  }
  if (state == FlightState::kLinkLost) return true;
  if (!IsFlying()) {
    is_preflight_fresh_ = false;
    Enter(FlightState::kDisconnected, "the vehicle is silent");
    return true;
  }
  before_link_loss_ = state;
  link_lost_s_ = vehicle_.heard_s;
  Enter(FlightState::kLinkLost, std::string("the vehicle is silent since ") + Name(state));
  return true;
}

// The vehicle's own failsafe may have acted; only when it is as we left it does the flight go on.
void MachineImpl::ReturnFromLinkLoss() {
  const double lost_for_s = now_s - link_lost_s_;
  const FlightState before = before_link_loss_;
  const bool is_ours = expected_.contains(vehicle_.mode) || leaving_.contains(vehicle_.mode);
  if (before == FlightState::kPilotOverride || !is_ours) {
    Enter(FlightState::kPilotOverride,
          "after the loss of the link the vehicle is in " + vehicle_.mode_name);
    return;
  }
  if (before == FlightState::kReturn || before == FlightState::kLand) {
    Enter(before, "the link is back");
    return;
  }
  if (before == FlightState::kPaused) {
    pause_cause_ = PauseCause::kRequested;
    Enter(FlightState::kPaused, "the link is back; it was paused before");
    return;
  }
  if (lost_for_s > options.resume_after_link_s) {
    StopHere(PauseCause::kRequested, "the link is back after a long loss; resume to go on");
    return;
  }
  came_from_stop_ = false;
  if (before == FlightState::kHold || before == FlightState::kFetch) {
    Enter(FlightState::kFetch, "the link is back");
  } else if (before == FlightState::kArmed || before == FlightState::kTakeoff) {
    Enter(FlightState::kTakeoff, "the link is back");
    if (vehicle_.landed == LandedState::kOnGround) BeginTakeoff();
  } else {
    BeginStop();
  }
}

bool MachineImpl::GuardArming() {
  if (state == FlightState::kConnected && !vehicle_.is_identified) return false;
  if (state == FlightState::kLinkLost || state == FlightState::kDisconnected) return false;
  if (vehicle_.is_armed && !IsFlying() && vehicle_.landed != LandedState::kOnGround) {
    // In the air, and not by us: either this daemon was started again, or a pilot took off.
    expected_ = {vehicle_.mode};
    leaving_.clear();
    const bool is_restart = found_flying_ && ledger.was_flying;
    found_flying_ = false;
    if (is_restart) {
      pause_cause_ = PauseCause::kFoundFlying;
      Enter(FlightState::kPaused,
            "found in the air in " + vehicle_.mode_name + " after a restart; resume or abort");
      AskCamera();
    } else {
      Enter(FlightState::kPilotOverride, "somebody else flies the vehicle");
    }
    return true;
  }
  if (IsFlying() && !vehicle_.is_armed) {
    const bool is_wanted = state == FlightState::kReturn || state == FlightState::kLand;
    Record({{"type", "end"}});
    is_preflight_fresh_ = false;
    Enter(FlightState::kDisarmed,
          is_wanted ? "landed" : std::string("the vehicle was disarmed in ") + Name(state));
    return true;
  }
  return false;
}

bool MachineImpl::GuardMode() {
  if (vehicle_.mode == VehicleMode::kUnknown) return false;
  if (state == FlightState::kPilotOverride) return false;
  if (expected_.contains(vehicle_.mode)) {
    if (arrived_in_mode_s_ < 0) {
      arrived_in_mode_s_ = now_s;
      // From here on these can only be somebody else's.
      for (const VehicleMode mode :
           {VehicleMode::kPilot, VehicleMode::kMission, VehicleMode::kReturn, VehicleMode::kLand}) {
        leaving_.erase(mode);
      }
    }
    return false;
  }
  const bool is_leaving = arrived_in_mode_s_ < 0 || now_s - arrived_in_mode_s_ < kModeLagS;
  if (is_leaving && leaving_.contains(vehicle_.mode)) return false;
  Enter(FlightState::kPilotOverride,
        "the vehicle changed to " + vehicle_.mode_name + ", by its pilot or a failsafe of its own");
  return true;
}

bool MachineImpl::IsPositionGood() const {
  return vehicle_.position && now_s - vehicle_.position_heard_s < kPositionTimeoutS &&
         vehicle_.gps_fix >= 3 && vehicle_.sigma_horizontal_m.value_or(0) <= options.max_sigma_m &&
         vehicle_.is_estimate_good.value_or(true);
}

bool MachineImpl::GuardPosition() {
  if (IsPositionGood()) {
    bad_position_since_s_ = -1;
    if (good_position_since_s_ < 0) good_position_since_s_ = now_s;
    const bool may_go_on = state == FlightState::kPaused && pause_cause_ == PauseCause::kPosition &&
                           !is_resuming_ && now_s - good_position_since_s_ >= kGoodPositionAgainS;
    if (may_go_on) is_resuming_ = true;
    return false;
  }
  good_position_since_s_ = -1;
  if (bad_position_since_s_ < 0) bad_position_since_s_ = now_s;
  const bool is_on_the_way = state == FlightState::kGoto || state == FlightState::kSettle ||
                             state == FlightState::kAim || state == FlightState::kCapture;
  if (!is_on_the_way || now_s - bad_position_since_s_ < kBadPositionS) return false;
  StopHere(PauseCause::kPosition, "the position is not reliable; goes on when it is again");
  return true;
}

double MachineImpl::PercentPerMinute() const {
  const double minutes = (now_s - flight_started_s_) / 60;
  if (!percent_at_start_ || !vehicle_.battery_percent || minutes < 1) {
    return options.percent_per_minute;
  }
  // Never less than half of what is assumed: batteries report steps.
  return std::max(options.percent_per_minute / 2,
                  (*percent_at_start_ - *vehicle_.battery_percent) / minutes);
}

bool MachineImpl::HasEnergyFor(const std::vector<Eigen::Vector3d>& legs, double hover_s) const {
  if (!vehicle_.battery_percent || !vehicle_.position) return true;
  EnergyNeed need;
  need.hover_s = hover_s + (legs.empty() ? 0 : kPhotoEnergyS);
  Eigen::Vector3d place = Position();
  for (const Eigen::Vector3d& leg : legs) {
    need.way_m += (leg - place).norm();
    place = leg;
  }
  const Eigen::Vector3d home = Space().home;
  need.return_m = (place - home).head<2>().norm();
  need.height_m = place.z() - home.z();
  return *vehicle_.battery_percent >=
         options.reserve_percent + BatteryNeeded(need, mission.speed_m_s, PercentPerMinute());
}

// Also hovering costs: while the daemon has the vehicle, it goes home in time. After a restart and
// under a pilot, that is for the vehicle's own failsafe.
bool MachineImpl::GuardBattery() {
  const bool is_waiting =
      state == FlightState::kHold || state == FlightState::kFetch ||
      (state == FlightState::kPaused && pause_cause_ != PauseCause::kFoundFlying);
  if (!is_waiting || HasEnergyFor({}, 0)) return false;
  BeginReturn("the battery is needed for the way home");
  return true;
}

void MachineImpl::StopHere(PauseCause cause, const std::string& why) {
  pause_cause_ = cause;
  is_resuming_ = false;
  output.cancel_motion = true;
  output.commands.clear();
  Enter(FlightState::kPaused, why);
  FlightCommand command;
  command.kind = CommandKind::kHold;
  if (vehicle_.position) {
    command.target = *vehicle_.position;
    command.relative_height_m = vehicle_.relative_height_m;
    command.yaw_rad = vehicle_.yaw_rad;
    Expect({VehicleMode::kGuided, VehicleMode::kBrake});
    Send(command);
  }
  came_from_stop_ = false;
}

}  // namespace colmap_ext
