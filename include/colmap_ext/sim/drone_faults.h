// What can be made to go wrong with a simulated drone.
#pragma once

#include <optional>
#include <string>

#include "colmap_ext/mavlink/lossy_link.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/sim/autopilot.h"

namespace colmap_ext {

// Faults that last.
struct DroneFaults {
  LossyLinkOptions link;  // both ways; simulated seconds
  double gps_glitch_m = 0;
  bool gps_lost = false;
  CameraFault camera = CameraFault::kNone;
  bool gimbal_stuck = false;
  WindOptions wind;
};

// Things that happen once.
struct DroneEvents {
  std::optional<std::string> pilot_mode;
  std::optional<double> battery_percent;
  bool crash = false;
};

// Reads the faults to change from a JSON object (docs/simulated_drone.md): all of them or none.
// Throws UsageError naming the key and what is wrong with it.
DroneEvents ChangeFaults(const std::string& json_text, DroneFaults* faults);

Json ToJson(const DroneFaults& faults);

// Makes `drone` have them; the link is the caller's.
void Apply(const DroneFaults& faults, SimulatedAutopilot* drone);

}  // namespace colmap_ext
