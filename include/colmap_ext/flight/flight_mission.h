// What the planner asks the daemon to fly.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

struct FlightStop {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world (ENU), metres
  ViewDirection direction;
  int view_id = -1;   // the view photographed here, unique in a session; -1: flown through
  std::string photo;  // file name of its photo, "view_00012.jpg"; empty without a view
};

// Where the vehicle may be. Checked by the daemon for every segment, whatever the planner said.
struct MissionLimits {
  double min_relative_height_m = 1.5;  // above home, on the way between views
  double max_relative_height_m = 120;  // above home; 120 m is the law in the EU and the US
  double max_distance_m = 500;         // from home, horizontally
  std::vector<Eigen::Vector2d> fence;  // inclusion polygon, world x and y, metres; empty: none
  // Geofence, no-fly zones and altitudes of the site (z of the world). A mission with a stop, or a
  // way between two stops, outside of them is refused.
  FlightLimits site;
};

enum class AtEnd { kHold, kReturn, kLand };

struct FlightMission {
  int revision = 1;         // grows with every append
  GeoPosition origin;       // of the world; the height as in the photos' positions
  double undulation_m = 0;  // height of the world's datum surface above mean sea level's:
                            // AMSL = height - undulation
  // Planned height (z of the world) of the take-off place. The flight is refused when the vehicle
  // stands more than 2 m off.
  std::optional<double> home_z_m;
  std::vector<FlightStop> stops;
  MissionLimits limits;
  double speed_m_s = 3;  // (0, 30]
  // Least distance from `surface` anywhere, metres; the planner's, less its tolerance of proof.
  double safe_distance_m = 5;
  // Mesh (PLY, world frame) to keep away from. Empty: nothing is known; then `is_vouched` must say
  // that a person vouches for the straight lines between the stops, in their order.
  std::filesystem::path surface_path;
  bool is_vouched = false;
  // Height (z of the world) above everything, for ways that the planner did not plan: from home to
  // the first stop, and back into the mission after somebody else flew. Absent: only straight ways.
  std::optional<double> transit_z_m;
  AtEnd at_end = AtEnd::kReturn;
  bool full_resolution = false;  // fetch the photos at full resolution, too

  // Complaint, or empty: finite numbers, unique view ids, file names without folders, ranges.
  std::string Check() const;

  // World from a position above mean sea level, and back.
  Eigen::Vector3d WorldFromAmsl(const GeoPosition& amsl) const;
  GeoPosition AmslFromWorld(const Eigen::Vector3d& position_in_world) const;
};

// The body of POST /v1/mission (docs/flight_api.md), and of flight/mission.json. The reader throws
// Error naming the JSON pointer of what is wrong; `name` stands for the file in its messages.
Json MissionToJson(const FlightMission& mission);
FlightMission MissionFromJson(const Json& json, const std::string& name);
// Only an array of stops, as in "stops" above.
std::vector<FlightStop> StopsFromJson(const JsonNode& node);

}  // namespace colmap_ext
