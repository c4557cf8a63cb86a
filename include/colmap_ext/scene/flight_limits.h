// Where a vehicle may be, apart from obstacles: geofence, no-fly zones, altitude limits.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

// An upright prism: a polygon in the plane, between two heights. World (ENU), metres.
struct FlightZone {
  enum class Kind {
    kInclusion,  // the vehicle stays inside (of one of them, when there are several)
    kExclusion,  // the vehicle stays outside
  };
  Kind kind = Kind::kInclusion;
  std::string name;  // for messages; may be empty
  // In x and y; a place is inside by IsInsideRings.
  std::vector<PolygonRing> rings;
  double min_z_m = -std::numeric_limits<double>::infinity();
  double max_z_m = std::numeric_limits<double>::infinity();

  bool Contains(const Eigen::Vector3d& point) const;
  // Distance to the zone's boundary, a lower bound: positive inside, negative outside, metres.
  // Infinite for a zone without rings that is unlimited in height.
  double Depth(const Eigen::Vector3d& point) const;
};

// Immutable in use; may be asked from many threads. A default-constructed one allows everything.
struct FlightLimits {
  std::vector<FlightZone> zones;
  // Of all flight, z of the world, metres.
  double min_z_m = -std::numeric_limits<double>::infinity();
  double max_z_m = std::numeric_limits<double>::infinity();

  bool IsEmpty() const;

  // Every place nearer to `point` than this is allowed (metres; infinite without limits). Negative
  // or 0: the point itself is not. Changes by at most the distance between two points, so that a
  // segment can be proved by sphere steps.
  double Margin(const Eigen::Vector3d& point) const;
  bool Allows(const Eigen::Vector3d& point, double margin_m = 0) const {
    return Margin(point) > margin_m;
  }
  // Whether all of the segment keeps `margin_m`; segments that keep it by less than `tolerance_m`
  // (> 0) may be refused.
  bool AllowsSegment(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double margin_m,
                     double tolerance_m = 0.01) const;

  // Empty where the point is allowed, else why it is not: "outside the geofence", "inside the
  // no-fly zone 'school'", "above the highest altitude".
  std::string WhyNot(const Eigen::Vector3d& point) const;
};

// Reads the zones of a GeoJSON file (RFC 7946): Polygon and MultiPolygon, bare, in a Feature or in
// a FeatureCollection. Properties of a feature:
//   "fence": "inclusion" (the default) or "exclusion"
//   "name": text
//   "min_altitude_m", "max_altitude_m": the zone's heights, z of the world (above its origin)
// Coordinates are longitude, latitude (degrees). In a file with the member "frame": "enu_m" beside
// "type" at its top they are x, y of the world in metres: indoors, without an origin on Earth.
// Throws Error naming file and JSON pointer of what is wrong: other geometries, rings of fewer than
// three corners, numbers that are not finite or no longitude and latitude, min above max; and when
// the file has longitudes and latitudes but `frame` has no origin.
FlightLimits ReadFlightLimits(const std::filesystem::path& geojson_path, const WorldFrame& frame);

}  // namespace colmap_ext
