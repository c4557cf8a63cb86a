// What must be true before the daemon arms the vehicle.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/vehicle_state.h"

namespace colmap_ext {

// What the driver found out for it.
struct PreflightFacts {
  std::map<std::string, double> parameters;  // those that answered
  bool fence_uploaded = false;               // written and read back the same
  std::string fence_problem;                 // why not
  bool has_gimbal = false;
  bool has_camera = false;
};

struct PreflightItem {
  std::string name;  // "battery"
  bool is_good = true;
  // A failsafe of the vehicle that is off: FlightOptions::allow_disabled_failsafes lets it pass.
  bool is_failsafe = false;
  std::string text;  // what was found, and what to do when it is not good
};

// Parameters that CheckPreflight wants to know of this stack.
std::vector<std::string> PreflightParameters(AutopilotStack stack);

// Every check, the good ones too. `highest_m`: top of what is known below the way home, above home,
// metres; the vehicle must return above it.
std::vector<PreflightItem> CheckPreflight(const VehicleState& vehicle, const PreflightFacts& facts,
                                          const FlightMission& mission, double highest_m,
                                          const FlightOptions& options);

// The items that forbid arming.
std::vector<PreflightItem> Blocking(const std::vector<PreflightItem>& items,
                                    const FlightOptions& options);

}  // namespace colmap_ext
