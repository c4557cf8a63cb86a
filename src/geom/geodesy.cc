#include "colmap_ext/geom/geodesy.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>

namespace colmap_ext {

bool IsValid(const GeoPosition& position) {
  return std::isfinite(position.lat_deg) && std::isfinite(position.lon_deg) &&
         std::isfinite(position.height_m) && std::abs(position.lat_deg) <= 90.0 &&
         std::abs(position.lon_deg) <= 180.0;
}

Eigen::Vector3d EnuFromGeo(const GeoPosition& origin, const GeoPosition& position) {
  const GeographicLib::LocalCartesian frame(origin.lat_deg, origin.lon_deg, origin.height_m);
  Eigen::Vector3d enu;
  frame.Forward(position.lat_deg, position.lon_deg, position.height_m, enu.x(), enu.y(), enu.z());
  return enu;
}

GeoPosition GeoFromEnu(const GeoPosition& origin, const Eigen::Vector3d& position_in_enu) {
  const GeographicLib::LocalCartesian frame(origin.lat_deg, origin.lon_deg, origin.height_m);
  GeoPosition position;
  frame.Reverse(position_in_enu.x(), position_in_enu.y(), position_in_enu.z(), position.lat_deg,
                position.lon_deg, position.height_m);
  return position;
}

int UtmZoneOf(const GeoPosition& position) {
  return GeographicLib::UTMUPS::StandardZone(position.lat_deg, position.lon_deg);
}

UtmPosition UtmFromGeo(const GeoPosition& position, int zone) {
  UtmPosition utm;
  GeographicLib::UTMUPS::Forward(position.lat_deg, position.lon_deg, utm.zone, utm.is_north,
                                 utm.easting_m, utm.northing_m, zone);
  return utm;
}

}  // namespace colmap_ext
