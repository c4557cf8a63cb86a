// QGroundControl's mission file (.plan), for PX4 and ArduPilot.
#pragma once

#include <string>

#include "colmap_ext/mission/mission.h"

namespace colmap_ext {

// The JSON text of a plan of plain SimpleItems: take-off, speed, then for each view gimbal →
// waypoint with hold and heading → capture → delay, for other waypoints the waypoint alone, and
// return to launch. ArduCopter ignores a waypoint's heading, so it also gets a heading command and
// a delay to turn, after the waypoint (a new waypoint would reset it). The fence and no-fly areas
// of the options are in it (their altitude limits have no place there). The leg from home to the
// first waypoint and the return are the autopilot's own: not proved here. Where the height of home
// above the sea is not known, that in the frame's datum stands for it: QGroundControl only shows
// it.
std::string QgcPlan(const Mission& mission, const MissionOptions& options);

// The same from a path; throws as PrepareMission does.
std::string QgcPlan(const FlightPath& path, const WorldFrame& frame, const MissionOptions& options);

}  // namespace colmap_ext
