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

}  // namespace colmap_ext
