// From the first command to the last landing: what each state waits for.
#include <algorithm>
#include <cmath>

#include "flight/machine_impl.h"

namespace colmap_ext {
namespace {

constexpr double kGuidedTimeoutS = 8;
constexpr double kArmRetryS = 3;
constexpr double kTakeoffTimeoutS = 60;
constexpr double kStartMovingS = 5;   // an accepted target that moves nothing was not taken
constexpr double kSameTargetM = 1.5;  // the autopilot's own word for it
constexpr double kSettledForS = 0.4;  // all tolerances hold so long
constexpr double kNearStopM = 3;      // here the way to the next stop is the planner's
constexpr double kHomeRetryS = 5;
constexpr int kHomeAttempts = 5;
constexpr double kTakeoffStartM = 2;  // below, the ground is nearer than any safe distance

}  // namespace

void MachineImpl::AdvancePreflight() {
  if (Last(CommandKind::kPreflight).HasFailed()) {
    start_wanted_ = false;
    Enter(FlightState::kIdentified, "the checks failed: " + Last(CommandKind::kPreflight).text);
    return;
  }
  if (!is_preflight_fresh_) return;
  const std::vector<PreflightItem> blocking = Blocking(items, options);
  if (!blocking.empty()) {
    start_wanted_ = false;
    Enter(FlightState::kIdentified,
          "not ready: " + blocking.front().name + ": " + blocking.front().text);
    return;
  }
  if (reason == "checking") Enter(FlightState::kPreflight, "ready");
  if (start_wanted_) AdvanceArming();
}

// Guided mode first, then arming, so that the vehicle is never armed in a mode that is not ours.
void MachineImpl::AdvanceArming() {
  if (vehicle_.is_armed) {
    Record({{"type", "start"}});
    start_wanted_ = false;
    flight_started_s_ = now_s;
    percent_at_start_ = vehicle_.battery_percent;
    failures_in_a_row_ = 0;
    expected_ = {VehicleMode::kGuided};
    leaving_.clear();
    Enter(FlightState::kArmed, "armed");
    return;
  }
  if (reason != "arming") {
    Enter(FlightState::kPreflight, "arming");
    entered_s_ = now_s;
    last_.erase(CommandKind::kArm);
    Send(CommandKind::kGuided);
    return;
  }
  const AwaitedCommand& arm = Last(CommandKind::kArm);
  const bool is_waiting = arm.id != 0 && !arm.outcome;
  if (InState() > options.arm_timeout_s && !is_waiting) {
    start_wanted_ = false;
    Enter(FlightState::kIdentified,
          "the vehicle does not arm: " + (arm.text.empty() ? "no answer" : arm.text));
    return;
  }
  if (vehicle_.mode != VehicleMode::kGuided) {
    const AwaitedCommand& guided = Last(CommandKind::kGuided);
    if (guided.outcome && now_s - guided.sent_s > kArmRetryS) Send(CommandKind::kGuided);
    return;
  }
  if (!is_waiting && (arm.id == 0 || now_s - arm.sent_s > kArmRetryS)) Send(CommandKind::kArm);
}

void MachineImpl::BeginTakeoff() {
  const FlightSpace space = Space();
  const Eigen::Vector3d here = Position();
  double height_m = std::max({options.takeoff_height_m, mission.limits.min_relative_height_m,
                              surface_ ? mission.safe_distance_m : 0.0});
  if (next_stop < static_cast<int>(mission.stops.size())) {
    const double first_m =
        mission.stops[static_cast<std::size_t>(next_stop)].position.z() - space.home.z();
    height_m = std::max(height_m, std::min(first_m, mission.limits.max_relative_height_m));
  }
  if (!surface_) height_m = std::max(height_m, *mission.transit_z_m - space.home.z());
  const Eigen::Vector3d above(here.x(), here.y(), space.home.z() + height_m);
  const Eigen::Vector3d start(here.x(), here.y(),
                              std::min(above.z(), space.home.z() + kTakeoffStartM));
  const std::string complaint = CheckSegment(space, start, above);
  if (!complaint.empty()) {
    BeginLanding("no take-off: " + complaint);
    return;
  }
  takeoff_z_m_ = above.z();
  FlightCommand command;
  command.kind = CommandKind::kTakeoff;
  command.target = mission.AmslFromWorld(above);
  command.relative_height_m = height_m;
  command.yaw_rad = vehicle_.yaw_rad;
  Expect({VehicleMode::kTakeoff, VehicleMode::kGuided});
  Enter(FlightState::kTakeoff, "");
  Send(command);
}

void MachineImpl::AdvanceTakeoff() {
  const AwaitedCommand& takeoff = Last(CommandKind::kTakeoff);
  const bool is_up = Position().z() >= takeoff_z_m_ - std::max(0.2, options.settle_distance_m);
  if (is_up && vehicle_.mode == VehicleMode::kGuided) {
    Expect({VehicleMode::kGuided});
    came_from_stop_ = false;
    BeginStop();
    return;
  }
  const bool is_on_ground = vehicle_.landed == LandedState::kOnGround;
  if (takeoff.HasFailed() && is_on_ground) {
    if (InState() < kTakeoffTimeoutS / 2) {
      if (now_s - takeoff.sent_s > kArmRetryS) BeginTakeoff();
    } else {
      BeginLanding("the vehicle does not take off: " + takeoff.text);
    }
    return;
  }
  if (InState() > kTakeoffTimeoutS) {
    if (is_on_ground) {
      BeginLanding("the vehicle does not take off");
    } else {
      BeginReturn("the take-off did not reach its height");
    }
  }
}

bool MachineImpl::IsDone(int stop) const {
  const int view_id = mission.stops[static_cast<std::size_t>(stop)].view_id;
  if (view_id < 0) return true;
  const auto entry = ledger.views.find(view_id);
  return entry != ledger.views.end() && (entry->second.status == ViewStatus::kCaptured ||
                                         entry->second.status == ViewStatus::kStored ||
                                         entry->second.status == ViewStatus::kFailed);
}

// The first stop to fly to, from index `from` on: the ways that lead to the next pending view, and
// only those. The number of stops when no view is pending.
int MachineImpl::NextPendingStop(int from) const {
  const int count = static_cast<int>(mission.stops.size());
  int stop = from;
  while (stop < count && IsDone(stop)) ++stop;
  if (stop == count) return count;
  // Back over the points that are only flown through on the way to it.
  while (stop > from && mission.stops[static_cast<std::size_t>(stop - 1)].view_id < 0) --stop;
  return stop;
}

// Goes to the next stop that can be reached, or ends the mission.
void MachineImpl::BeginStop() {
  const int count = static_cast<int>(mission.stops.size());
  while (true) {
    if (NextPendingStop(next_stop) == count) next_stop = count;
    if (next_stop == count) {
      Enter(FlightState::kFetch, "every stop is flown");
      return;
    }
    if (failures_in_a_row_ >= options.max_failures_in_a_row) {
      BeginReturn("too many views failed one after another: " + reason);
      return;
    }
    if (TryStop()) return;
  }
}

// False: the next stop was given up, and the one after it has to be tried.
bool MachineImpl::TryStop() {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  const FlightSpace space = Space();
  std::string complaint;
  const bool must_detour = !surface_ && !came_from_stop_;
  legs_ = PlanLegs(space, Position(), stop.position, mission.transit_z_m, must_detour, &complaint);
  if (legs_.empty()) {
    GiveUpStop(complaint);
    return false;
  }
  if (!HasEnergyFor(legs_, 0)) {
    BeginReturn("the battery is needed for the way home");
    return true;
  }
  leg_ = 0;
  leg_attempts_ = 0;
  settle_repeated_ = false;
  aim_repeated_ = false;
  capture_attempts_ = 0;
  is_resuming_ = false;
  Enter(FlightState::kGoto,
        stop.view_id >= 0 ? "view " + std::to_string(stop.view_id) : "on the way");
  FlyLeg();
  return true;
}

void MachineImpl::FlyLeg() {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  ++leg_attempts_;
  entered_s_ = now_s;
  leg_start_ = Position();
  FlightCommand command;
  command.kind = CommandKind::kGoTo;
  command.target = mission.AmslFromWorld(legs_[leg_]);
  command.relative_height_m = legs_[leg_].z() - Space().home.z();
  command.yaw_rad = stop.direction.yaw_rad;
  command.speed_m_s = mission.speed_m_s;
  Send(command);
  const bool is_last = leg_ + 1 == legs_.size();
  if (is_last && stop.view_id >= 0 && leg_attempts_ == 1) {
    FlightCommand aim;  // on the way already
    aim.kind = CommandKind::kAim;
    aim.pitch_rad = stop.direction.pitch_rad;
    aim.yaw_rad = stop.direction.yaw_rad;
    Send(aim);
  }
}

void MachineImpl::AdvanceGoto() {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  const double left_m = (Position() - legs_[leg_]).norm();
  if (left_m < options.settle_distance_m) {
    if (leg_ + 1 < legs_.size()) {
      ++leg_;
      leg_attempts_ = 0;
      FlyLeg();
    } else if (stop.view_id >= 0 && !IsDone(next_stop)) {
      settled_since_s_ = -1;
      Enter(FlightState::kSettle, reason);
    } else {
      FinishStop();
    }
    return;
  }
  const AwaitedCommand& goto_command = Last(CommandKind::kGoTo);
  const double length_m = (legs_[leg_] - leg_start_).norm();
  const bool moves = (Position() - leg_start_).norm() > std::min(0.5, length_m / 2) ||
                     vehicle_.velocity_in_enu.norm() > 0.3;
  const bool is_known =
      vehicle_.target &&
      (mission.WorldFromAmsl(*vehicle_.target) - legs_[leg_]).norm() < kSameTargetM;
  const bool is_refused = goto_command.outcome == CommandOutcome::kRejected;
  const bool is_ignored = goto_command.outcome && !moves && !is_known && InState() > kStartMovingS;
  const bool is_late = InState() > 3 * length_m / mission.speed_m_s + options.settle_timeout_s;
  if (!is_refused && !is_ignored && !is_late) return;
  if (leg_attempts_ < 2) {
    if (InState() > 1) FlyLeg();
    return;
  }
  if (is_late && moves) {
    StopHere(PauseCause::kRefused, "the vehicle does not arrive at stop " +
                                       std::to_string(next_stop) + "; resume to try again");
    return;
  }
  GiveUpStop(is_refused ? "the vehicle refuses the target: " + goto_command.text
                        : "the vehicle took the target and does not go there (its own fence?)");
  BeginStop();
}

bool MachineImpl::IsSettled() const {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  const double yaw_error = NormalizeAngle(vehicle_.yaw_rad - stop.direction.yaw_rad);
  return (Position() - stop.position).norm() < options.settle_distance_m &&
         vehicle_.velocity_in_enu.norm() < options.settle_speed_m_s &&
         std::abs(yaw_error) < DegToRad(options.settle_yaw_deg);
}

void MachineImpl::AdvanceSettle() {
  if (IsSettled()) {
    if (settled_since_s_ < 0) settled_since_s_ = now_s;
    if (now_s - settled_since_s_ >= kSettledForS) Enter(FlightState::kAim, reason);
    return;
  }
  settled_since_s_ = -1;
  if (InState() < options.settle_timeout_s) return;
  if (!settle_repeated_) {
    settle_repeated_ = true;
    FlyLeg();
    FlightCommand turn;
    turn.kind = CommandKind::kTurn;
    turn.yaw_rad = mission.stops[static_cast<std::size_t>(next_stop)].direction.yaw_rad;
    Send(turn);
    return;
  }
  GiveUpStop("the vehicle does not come to rest at the view");
  BeginStop();
}

bool MachineImpl::IsAimed() const {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  const auto aim = last_.find(CommandKind::kAim);
  const bool is_accepted = aim != last_.end() && aim->second.IsAccepted();
  if (!vehicle_.gimbal) {
    return is_accepted && now_s - aim->second.sent_s >= options.aim_wait_s;
  }
  const bool is_fresh = now_s - vehicle_.gimbal->heard_s < 2;
  return is_fresh && std::abs(vehicle_.gimbal->pitch_rad - stop.direction.pitch_rad) <
                         DegToRad(options.aim_tolerance_deg);
}

void MachineImpl::AdvanceAim() {
  if (IsAimed() && IsSettled()) {
    BeginCapture();
    return;
  }
  if (InState() < options.aim_timeout_s) return;
  if (!aim_repeated_) {
    aim_repeated_ = true;
    entered_s_ = now_s;
    FlightCommand aim;
    aim.kind = CommandKind::kAim;
    aim.pitch_rad = mission.stops[static_cast<std::size_t>(next_stop)].direction.pitch_rad;
    Send(aim);
    return;
  }
  GiveUpStop(IsAimed() ? "the vehicle does not stay at the view"
                       : "the gimbal does not come to its pitch");
  BeginStop();
}

void MachineImpl::FinishStop() {
  const bool was_view = mission.stops[static_cast<std::size_t>(next_stop)].view_id >= 0;
  if (was_view) failures_in_a_row_ = 0;
  came_from_stop_ = true;
  ++next_stop;
  BeginStop();
}

void MachineImpl::GiveUpStop(const std::string& why) {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  if (stop.view_id >= 0 && !IsDone(next_stop)) {
    Record({{"type", "failed"}, {"view", stop.view_id}, {"reason", why}});
    ++failures_in_a_row_;
  }
  reason = why;
  came_from_stop_ =
      came_from_stop_ && vehicle_.position && (Position() - stop.position).norm() < kNearStopM;
  ++next_stop;
}

void MachineImpl::AdvanceFetch() {
  const bool is_over = !IsFetchingLow() || InState() > options.fetch_timeout_s;
  if (!is_over) return;
  if (mission.at_end == AtEnd::kReturn) {
    BeginReturn("the mission is done");
  } else if (mission.at_end == AtEnd::kLand) {
    BeginLanding("the mission is done");
  } else {
    Enter(FlightState::kHold, "every stop is flown; append, or abort");
  }
}

void MachineImpl::AdvanceHold() {
  if (InState() > options.max_hold_s) BeginReturn("nobody appended views");
}

void MachineImpl::AdvancePaused() {
  if (!is_resuming_) return;
  const AwaitedCommand& guided = Last(CommandKind::kGuided);
  if (state == FlightState::kPaused && pause_cause_ == PauseCause::kPosition &&
      guided.sent_s < entered_s_) {
    Expect({VehicleMode::kGuided});
    Send(CommandKind::kGuided);
    return;
  }
  if (guided.IsAccepted() && vehicle_.mode == VehicleMode::kGuided) {
    came_from_stop_ = false;
    failures_in_a_row_ = 0;
    TakeUnreported();
    next_stop = NextPendingStop(std::min(next_stop, static_cast<int>(mission.stops.size())));
    Expect({VehicleMode::kGuided});
    BeginStop();
    is_resuming_ = false;
    return;
  }
  if (guided.HasFailed() || now_s - guided.sent_s > kGuidedTimeoutS) {
    is_resuming_ = false;
    expected_ = {vehicle_.mode};
    Enter(state, "the vehicle did not take guided mode: " + guided.text);
  }
}

void MachineImpl::BeginReturn(const std::string& why) {
  output.cancel_motion = true;
  Expect({VehicleMode::kReturn, VehicleMode::kLand});
  Enter(FlightState::kReturn, why);
  leg_attempts_ = 1;
  Send(CommandKind::kReturn);
}

void MachineImpl::BeginLanding(const std::string& why) {
  output.cancel_motion = true;
  Expect({VehicleMode::kLand});
  Enter(FlightState::kLand, why);
  leg_attempts_ = 1;
  Send(CommandKind::kLand);
}

// Asks again until the vehicle is in the mode; a refused return becomes a landing.
void MachineImpl::AdvanceGoingHome() {
  if (expected_.contains(vehicle_.mode)) return;
  const CommandKind kind =
      state == FlightState::kReturn ? CommandKind::kReturn : CommandKind::kLand;
  const AwaitedCommand& command = Last(kind);
  if (!command.outcome || now_s - command.sent_s < kHomeRetryS) return;
  if (leg_attempts_ < kHomeAttempts) {
    ++leg_attempts_;
    Send(kind);
  } else if (state == FlightState::kReturn) {
    BeginLanding("the vehicle does not return: " + command.text);
  } else {
    StopHere(PauseCause::kRefused, "the vehicle does not land: " + command.text);
  }
}

}  // namespace colmap_ext
