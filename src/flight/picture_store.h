// Puts pictures where the session looks for them.
#pragma once

#include <string>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/scene/workspace.h"

namespace colmap_ext {

// Writes the picture beside its place and renames it, and first, for the low resolution, its line
// into images/captures.jsonl (heights in the datum of the mission's world). Returns the SHA-256 of
// `bytes` in hexadecimal. Throws Error when `bytes` are no picture or cannot be written.
std::string StorePicture(const Workspace& workspace, const FetchRequest& request,
                         const FlightMission& mission, const std::string& bytes);

std::string Sha256Hex(const std::string& bytes);

}  // namespace colmap_ext
