// Latitude and longitude to local metres (WGS84 ellipsoid, GeographicLib).
#pragma once

#include <Eigen/Core>

namespace colmap_ext {

// Degrees here by exception: files, EXIF and MAVLink all speak degrees, and the names say so.
struct GeoPosition {
  double lat_deg = 0;
  double lon_deg = 0;
  double height_m = 0;  // above the ellipsoid, or whatever datum the source used, kept consistent
};

bool IsValid(const GeoPosition& position);  // finite, |lat| <= 90, |lon| <= 180

// Local tangent frame at `origin`: x east, y north, z up, metres.
Eigen::Vector3d EnuFromGeo(const GeoPosition& origin, const GeoPosition& position);
GeoPosition GeoFromEnu(const GeoPosition& origin, const Eigen::Vector3d& position_in_enu);

// Coordinates on the UTM grid, WGS84.
struct UtmPosition {
  int zone = 0;  // 1 … 60
  bool is_north = true;
  double easting_m = 0;
  double northing_m = 0;  // from the equator; in the south plus 10 000 km
};

// The UTM zone of a position; 0 near the poles, where there is none.
int UtmZoneOf(const GeoPosition& position);
// In the given zone (and the hemisphere of `position`), also from a little outside of it.
UtmPosition UtmFromGeo(const GeoPosition& position, int zone);

}  // namespace colmap_ext
