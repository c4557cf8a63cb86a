// Flies the uploaded mission, with what the stacks make of its items.
#include <cmath>

#include "sim/autopilot_impl.h"

namespace colmap_ext {
namespace {

bool IsPlace(MavCmd command) {
  return command == MavCmd::kNavWaypoint || command == MavCmd::kNavTakeoff;
}

}  // namespace

bool SimulatedAutopilot::Impl::StartMission(int first) {
  const auto& items = missions.Items(MavMissionType::kMission);
  if (first >= static_cast<int>(items.size())) {
    Say(MavSeverity::kWarning, "No valid mission available");
    return false;
  }
  // A paused mission goes on where it was.
  if (mission_item < first || is_mission_done) mission_item = first;
  is_item_begun = is_mission_done = false;
  return true;
}

MotionTarget SimulatedAutopilot::Impl::MissionTarget() { return GoalTarget(); }

void SimulatedAutopilot::Impl::StepMission() {
  if (!is_armed || is_mission_done) return;
  const auto& items = missions.Items(MavMissionType::kMission);
  // DO items take no time; several may run in one step.
  for (int guard = 0; guard < 1000; ++guard) {
    if (mission_item >= static_cast<int>(items.size())) {
      is_mission_done = true;
      if (is_px4) EnterMode(FlightMode::kGuided);
      return;
    }
    if (!is_item_begun) BeginItem();
    is_item_begun = true;
    if (mode != FlightMode::kMission || !IsItemDone()) return;
    AdvanceMission();
  }
}

void SimulatedAutopilot::Impl::AdvanceMission() {
  MavMissionItemReached reached;
  reached.seq = static_cast<std::uint16_t>(mission_item);
  Send(reached);
  ++mission_item;
  is_item_begun = false;
}

void SimulatedAutopilot::Impl::BeginItem() {
  const MavMissionItemInt& item =
      missions.Items(MavMissionType::kMission)[static_cast<std::size_t>(mission_item)];
  item_wait_until_s = -1;
  if (RunDoItem(item)) return;
  if (!IsPlace(item.command)) {
    if (item.command == MavCmd::kNavReturnToLaunch) EnterMode(FlightMode::kReturn);
    if (item.command == MavCmd::kNavLand) EnterMode(FlightMode::kLand);
    if (item.command == MavCmd::kNavDelay) {
      item_wait_until_s = Now() + std::max(0.0, static_cast<double>(item.param1));
    }
    return;
  }
  const bool is_amsl =
      item.frame == MavCoordinateFrame::kGlobal || item.frame == MavCoordinateFrame::kGlobalInt;
  const double z =
      static_cast<double>(item.z) + (is_amsl ? -origin.height_m : home.value_or(Estimated()).z());
  const double speed = speed_m_s;
  Eigen::Vector3d next = EnuFromGeo(origin, {item.x * 1e-7, item.y * 1e-7, origin.height_m + z});
  if (item.command == MavCmd::kNavTakeoff) {
    is_taking_off = is_landed;
    next = {Estimated().x(), Estimated().y(), z};
  }
  SetGoal(next);
  if (speed > 0) speed_m_s = speed;  // DO_CHANGE_SPEED lasts
  // ArduPilot ignores a waypoint's yaw.
  yaw_follows_travel = !is_px4 || !std::isfinite(item.param4);
  if (!yaw_follows_travel) goal_yaw = DegToRad(static_cast<double>(item.param4));
}

// Done at once, true; false: it takes time.
bool SimulatedAutopilot::Impl::RunDoItem(const MavMissionItemInt& item) {
  switch (item.command) {
    case MavCmd::kNavWaypoint:
    case MavCmd::kNavTakeoff:
    case MavCmd::kNavReturnToLaunch:
    case MavCmd::kNavLand:
    case MavCmd::kNavDelay:
      return false;
    case MavCmd::kConditionYaw:
      if (!is_px4) {
        goal_yaw = DegToRad(static_cast<double>(item.param1));
        yaw_follows_travel = false;
      }
      return true;
    case MavCmd::kDoChangeSpeed:
      if (item.param2 > 0) speed_m_s = static_cast<double>(item.param2);
      return true;
    case MavCmd::kImageStartCapture:
      StartCapture(0);
      return true;
    case MavCmd::kDoDigicamControl:
      if (item.y == 1 || item.x == 1) StartCapture(0);
      return true;
    case MavCmd::kDoGimbalManagerPitchyaw:
    case MavCmd::kDoMountControl:
      AimGimbal(DegToRad(static_cast<double>(item.param1)), 0, 0);
      return true;
    default:
      return true;
  }
}

bool SimulatedAutopilot::Impl::IsItemDone() {
  const MavMissionItemInt& item =
      missions.Items(MavMissionType::kMission)[static_cast<std::size_t>(mission_item)];
  if (item.command == MavCmd::kNavDelay) return Now() >= item_wait_until_s;
  if (item.command == MavCmd::kNavReturnToLaunch || item.command == MavCmd::kNavLand) return false;
  if (!IsPlace(item.command)) return true;
  if (item.command == MavCmd::kNavTakeoff) return !is_taking_off && !is_landed;
  // ArduPilot ignores the radius of the item.
  double radius = is_px4 ? parameters.Get("NAV_ACC_RAD") : parameters.Get("WPNAV_RADIUS") * 0.01;
  if (is_px4 && item.param2 > 0) radius = static_cast<double>(item.param2);
  const bool turns = is_px4 && std::isfinite(item.param4);
  const bool is_turned =
      !turns || std::abs(NormalizeAngle(goal_yaw - motion.state().yaw_rad)) < DegToRad(12);
  if (item_wait_until_s < 0) {
    if ((Estimated() - goal).norm() > radius || !is_turned) return false;
    item_wait_until_s = Now() + std::max(0.0, static_cast<double>(item.param1));
  }
  return Now() >= item_wait_until_s;
}

}  // namespace colmap_ext
