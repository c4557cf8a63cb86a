#include <cstdio>

#include "colmap_ext/mission/export_formats.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMostWaypoints = 99;
constexpr int kActions = 15;
// actiontype
constexpr int kNoAction = -1;
constexpr int kStay = 0;  // its parameter: milliseconds
constexpr int kPhoto = 1;
constexpr int kGimbalInterpolated = 2;

std::string Header() {
  std::string text =
      "latitude,longitude,altitude(m),heading(deg),curvesize(m),rotationdir,gimbalmode,"
      "gimbalpitchangle";
  for (int i = 1; i <= kActions; ++i) {
    const std::string number = std::to_string(i);
    text += ",actiontype" + number + ",actionparam" + number;
  }
  return text +
         ",altitudemode,speed(m/s),poi_latitude,poi_longitude,poi_altitude(m),poi_altitudemode,"
         "photo_timeinterval,photo_distinterval\n";
}

std::string Row(const MissionStop& stop, const MissionOptions& options) {
  char text[200];
  // Curve size 0: it flies to the point itself. Rotation 0: clockwise.
  std::snprintf(text, sizeof text, "%.8f,%.8f,%.3f,%.3f,0,0,%d,%.3f", stop.lat_deg, stop.lon_deg,
                stop.height.relative_m, HeadingDeg(stop.direction), kGimbalInterpolated,
                RadToDeg(stop.direction.pitch_rad));
  std::string row = text;
  int actions = 0;
  const auto add = [&](int type, int param) {
    row += "," + std::to_string(type) + "," + std::to_string(param);
    ++actions;
  };
  if (stop.view_id >= 0) {
    add(kStay, static_cast<int>(1000 * options.hold_s));
    add(kPhoto, 0);
  }
  while (actions < kActions) add(kNoAction, 0);
  // Altitude above the take-off; no point of interest; no photos on the way.
  return row + ",0," + FormatNumber("%.2f", options.speed_m_s) + ",0,0,0,0,-1,-1\n";
}

}  // namespace

std::string LitchiCsv(const Mission& mission, const MissionOptions& options) {
  if (options.height_reference != "relative") {
    throw Error("Litchi: its heights are relative to the take-off, there are no others");
  }
  if (mission.stops.size() > kMostWaypoints) {
    throw Error("Litchi: at most 99 waypoints, and this flight has " +
                std::to_string(mission.stops.size()) +
                "; plan shorter flights with a lower --Path.battery_s, or choose another format");
  }
  std::string text = Header();
  for (const MissionStop& stop : mission.stops) text += Row(stop, options);
  return text;
}

}  // namespace colmap_ext
