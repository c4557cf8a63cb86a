#pragma once

#include <string>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/flight/vehicle_state.h"

namespace colmap_ext {

// Every MAVLink command that a flight of `mission` without incidents would send to such a vehicle
// standing at `home` (world), one a line with all its parameters, in order. Nothing is sent and no
// vehicle is needed.
std::string DryRunText(const FlightMission& mission, AutopilotStack stack,
                       const Eigen::Vector3d& home, double takeoff_height_m);

}  // namespace colmap_ext
