#pragma once

#include <array>
#include <vector>

#include "colmap_ext/mission/mission.h"

namespace colmap_ext {

// MAV_FRAME
inline constexpr int kFrameGlobalAmsl = 0;
inline constexpr int kFrameMission = 2;
inline constexpr int kFrameGlobalRelative = 3;

// An item of a MAVLink mission.
struct MissionItem {
  int command = 0;  // MAV_CMD
  int frame = kFrameMission;
  std::array<double, 7> params{};  // NaN: the autopilot's default

  bool IsPlace() const { return frame != kFrameMission; }
};

// Take-off, speed, then for each view gimbal → waypoint with hold and heading → capture → delay,
// for other stops the waypoint alone, and return to launch.
std::vector<MissionItem> MissionItems(const Mission& mission, const MissionOptions& options);

}  // namespace colmap_ext
