#include "mission/mission_items.h"

#include <algorithm>
#include <limits>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// MAV_CMD
constexpr int kWaypoint = 16;
constexpr int kReturnToLaunch = 20;
constexpr int kTakeoff = 22;
constexpr int kDelay = 93;
constexpr int kConditionYaw = 115;
constexpr int kChangeSpeed = 178;
constexpr int kGimbalPitchYaw = 1000;
constexpr int kStartCapture = 2000;

MissionItem Place(int command, double hold_s, double heading_deg, const MissionStop& stop,
                  const MissionOptions& options) {
  const bool is_amsl = options.height_reference == "amsl";
  MissionItem item;
  item.command = command;
  item.frame = is_amsl ? kFrameGlobalAmsl : kFrameGlobalRelative;
  item.params = {hold_s,
                 0,
                 0,
                 heading_deg,
                 stop.lat_deg,
                 stop.lon_deg,
                 is_amsl ? *stop.height.amsl_m : stop.height.relative_m};
  return item;
}

MissionItem TakeOff(const Mission& mission, const MissionOptions& options) {
  MissionStop up = mission.home;
  const double climb_m =
      std::max(options.takeoff_height_m, mission.stops.front().height.relative_m);
  up.height.relative_m += climb_m;
  if (up.height.amsl_m) *up.height.amsl_m += climb_m;
  return Place(kTakeoff, 0, HeadingDeg(mission.stops.front().direction), up, options);
}

void AddView(const MissionStop& stop, int photo_number, const MissionOptions& options,
             std::vector<MissionItem>* items) {
  const double heading_deg = HeadingDeg(stop.direction);
  // Gimbal: pitch, yaw 0 (straight ahead of the vehicle, which turns), rates 0 (ArduPilot refuses
  // NaN there), flags 0, -, device 0.
  items->push_back({kGimbalPitchYaw, kFrameMission, {RadToDeg(stop.direction.pitch_rad)}});
  items->push_back(Place(kWaypoint, options.hold_s, heading_deg, stop, options));
  if (options.autopilot == "ardupilot") {
    items->push_back({kConditionYaw, kFrameMission, {heading_deg}});
    items->push_back({kDelay, kFrameMission, {std::max(1.0, options.hold_s), -1, -1, -1}});
  }
  items->push_back({kStartCapture,
                    kFrameMission,
                    {0, 0, 1, static_cast<double>(photo_number), kNan, kNan, kNan}});
  items->push_back({kDelay, kFrameMission, {options.capture_delay_s, -1, -1, -1}});
}

}  // namespace

std::vector<MissionItem> MissionItems(const Mission& mission, const MissionOptions& options) {
  if (options.height_reference == "ellipsoidal") {
    throw Error("mission: MAVLink missions take relative or amsl heights, not ellipsoidal ones");
  }
  std::vector<MissionItem> items = {TakeOff(mission, options)};
  items.push_back({kChangeSpeed, kFrameMission, {1, options.speed_m_s, -1}});
  int photo_number = 0;
  for (const MissionStop& stop : mission.stops) {
    if (stop.view_id >= 0) {
      AddView(stop, ++photo_number, options, &items);
    } else {
      items.push_back(Place(kWaypoint, 0, HeadingDeg(stop.direction), stop, options));
    }
  }
  items.push_back({kReturnToLaunch, kFrameMission, {}});
  return items;
}

}  // namespace colmap_ext
