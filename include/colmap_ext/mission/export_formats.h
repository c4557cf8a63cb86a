// Missions as files that drones' programs read. All texts are UTF-8 and end with a line end.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/mission/mission.h"

namespace colmap_ext {

// MAVLink "QGC WPL 110": 12 columns between tabs, for PX4 and ArduPilot (whose row 0 is home). It
// has no fence. Heights: relative, or AMSL.
std::string Wpl110(const Mission& mission, const MissionOptions& options);

// Litchi Mission Hub. Heights: relative to the take-off only. Set the heading mode "custom" after
// the import, which this format cannot. Throws Error when there are more than 99 stops.
std::string LitchiCsv(const Mission& mission, const MissionOptions& options);

// The two files of a DJI wayline (WPML 1.0.2). Heights: relative to the start point, or ellipsoidal
// (which the template calls EGM96 heights: they need AMSL too).
struct DjiWayline {
  std::string template_kml;
  std::string waylines_wpml;
};
DjiWayline DjiWpml(const Mission& mission, const MissionOptions& options);
// Zips them, atomically, as wpmz/template.kml and wpmz/waylines.wpml.
void WriteDjiKmz(const DjiWayline& wayline, const std::filesystem::path& path);

// KML 2.2 to look at: a line a flight and a point a view. Heights: AMSL ("absolute"), or relative
// ones drawn above the ground, which is right where the ground is as high as at home.
std::string Kml(const Mission& mission, const MissionOptions& options);

// GeoJSON (RFC 7946): a LineString "path", and a Point for each view with its id, yaw_deg,
// pitch_deg and heights. Coordinates are longitude, latitude, height above the ellipsoid; where
// that is not known, the height in the frame's datum, and "height_datum" says so.
std::string GeoJson(const Mission& mission);

// Everything there is, for programs of one's own: home, stops with all heights, fence, flights.
std::string MissionJson(const Mission& mission, const MissionOptions& options);

}  // namespace colmap_ext
