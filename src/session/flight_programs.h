// The command lines of the programs that a session starts for a flight, and their options files.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session.h"

namespace colmap_ext {

// A free port of 127.0.0.1 for MAVLink. Throws Error when there is none.
int FreeUdpPort();

// colmap_ext_dronesim, which sends to `link_port`, with the session's scene, camera and failsafes
// that a flight needs. Pictures go to `output_path`. It returns home above `site_top_m` (highest z
// of what is there, world). Writes logs/drone.ini.
std::vector<std::string> DroneArguments(const SessionInputs& inputs, const StageOptions& options,
                                        const Workspace& workspace, double site_top_m,
                                        int link_port, const std::filesystem::path& output_path);

// colmap_ext_flightd for the simulated drone on these ports. Writes logs/flight.ini.
std::vector<std::string> SimulationDaemonArguments(const StageOptions& options,
                                                   const Workspace& workspace, int link_port,
                                                   int drone_port);
// … and for the vehicle of SessionOptions::vehicle.
std::vector<std::string> VehicleDaemonArguments(const SessionInputs& inputs,
                                                const StageOptions& options,
                                                const Workspace& workspace);

}  // namespace colmap_ext
