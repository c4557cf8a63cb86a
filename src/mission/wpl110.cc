#include <cmath>
#include <cstdio>

#include "colmap_ext/mission/export_formats.h"
#include "mission/mission_items.h"

namespace colmap_ext {
namespace {

// Index, current, frame, command, four parameters, latitude, longitude, altitude, autocontinue.
std::string Row(int index, const MissionItem& item) {
  std::array<double, 7> p = item.params;
  for (double& param : p) {
    if (std::isnan(param)) param = 0;  // not every reader knows "nan"
  }
  char text[320];
  std::snprintf(text, sizeof text, "%d\t%d\t%d\t%d\t%.8f\t%.8f\t%.8f\t%.8f\t%.8f\t%.8f\t%.6f\t1\n",
                index, index == 0 ? 1 : 0, item.frame, item.command, p[0], p[1], p[2], p[3], p[4],
                p[5], p[6]);
  return text;
}

}  // namespace

std::string Wpl110(const Mission& mission, const MissionOptions& options) {
  std::string text = "QGC WPL 110\n";
  int index = 0;
  if (options.autopilot == "ardupilot") {
    const double home_m = mission.home.height.amsl_m.value_or(mission.frame_height_m);
    text += Row(
        index++,
        {16, kFrameGlobalAmsl, {0, 0, 0, 0, mission.home.lat_deg, mission.home.lon_deg, home_m}});
  }
  for (const MissionItem& item : MissionItems(mission, options)) text += Row(index++, item);
  return text;
}

}  // namespace colmap_ext
