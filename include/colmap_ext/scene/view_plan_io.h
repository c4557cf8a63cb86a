// views.json and path.json. Angles are degrees in the files; positions come back to the last bit,
// angles to 1e-15 of their size.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

// views.json: [{"id", "position_enu_m": [x,y,z], "lat", "lon", "height_m", "yaw_deg", "pitch_deg",
// "score"}]. lat, lon (degrees) and height_m only when `frame` has an origin; they are for other
// programs, the reader takes position_enu_m. Written atomically. Readers throw Error naming the
// file and JSON pointer of what is missing or wrong (also an id that occurs twice).
void WriteViews(const std::vector<PlannedView>& views, const WorldFrame& frame,
                const std::filesystem::path& path);
std::vector<PlannedView> ReadViews(const std::filesystem::path& path);

// path.json: {"waypoints": [{"position_enu_m", "lat", "lon", "height_m", "yaw_deg", "pitch_deg",
// "view_id"}], "length_m", "duration_s", "min_clearance_m", "dropped_view_ids": [id, …],
// "drop_reasons": ["…", …], "flights": [{"first_waypoint", "last_waypoint", "length_m",
// "duration_s", "return_s", "battery_share"}]}. The last two may be missing when reading.
void WritePath(const FlightPath& flight_path, const WorldFrame& frame,
               const std::filesystem::path& path);
FlightPath ReadPath(const std::filesystem::path& path);

}  // namespace colmap_ext
