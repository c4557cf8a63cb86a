#include <cmath>
#include <cstdlib>

#include "colmap_ext/mission/mission.h"

namespace colmap_ext {
namespace {

bool IsNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value);
}

}  // namespace

std::string MissionOptions::Check() const {
  if (autopilot != "px4" && autopilot != "ardupilot") {
    return "Mission.autopilot must be px4 or ardupilot";
  }
  if (!(speed_m_s > 0 && speed_m_s <= 30)) return "Mission.speed_m_s must be in (0, 30]";
  if (!(hold_s >= 0 && hold_s <= 600)) return "Mission.hold_s must be in 0 … 600";
  if (!(capture_delay_s >= 0 && capture_delay_s <= 600)) {
    return "Mission.capture_delay_s must be in 0 … 600";
  }
  if (!(takeoff_height_m > 0 && takeoff_height_m <= 1000)) {
    return "Mission.takeoff_height_m must be in (0, 1000]";
  }
  if (!std::isfinite(min_relative_height_m) || !std::isfinite(home_below_origin_m)) {
    return "Mission heights must be finite (metres)";
  }
  if (!IsValid({home_lat_deg, home_lon_deg, 0})) {
    return "Mission.home_lat_deg must be in -90 … 90 and Mission.home_lon_deg in -180 … 180";
  }
  if (frame_heights != "unknown" && frame_heights != "ellipsoidal" && frame_heights != "amsl") {
    return "Mission.frame_heights must be unknown, ellipsoidal or amsl";
  }
  if (height_reference != "relative" && height_reference != "amsl" &&
      height_reference != "ellipsoidal") {
    return "Mission.height_reference must be relative, amsl or ellipsoidal";
  }
  if (geoid_undulation_m != "auto" && !IsNumber(geoid_undulation_m)) {
    return "Mission.geoid_undulation_m must be auto or a number of metres";
  }
  for (const auto* areas : {&fence, &no_fly}) {
    for (const std::vector<GeoPosition>& area : *areas) {
      if (area.size() < 3) return "a fence or no-fly area needs at least 3 corners";
    }
  }
  return "";
}

void BindOptions(OptionSet& set, MissionOptions* options) {
  const std::string s = "Mission";
  set.Add(s, "autopilot", &options->autopilot, "px4 or ardupilot");
  set.Add(s, "speed_m_s", &options->speed_m_s, "flying speed (m/s, 0 … 30)");
  set.Add(s, "hold_s", &options->hold_s, "wait before a photo (seconds, 0 … 600)");
  set.Add(s, "capture_delay_s", &options->capture_delay_s, "wait after a photo (seconds, 0 … 600)");
  set.Add(s, "takeoff_height_m", &options->takeoff_height_m,
          "least height of the take-off above home (metres, 0 … 1000)");
  set.Add(s, "min_relative_height_m", &options->min_relative_height_m,
          "refuse waypoints lower than this above home (metres)");
  set.Add(s, "home_lat_deg", &options->home_lat_deg,
          "latitude of the take-off place; both 0: the frame's origin");
  set.Add(s, "home_lon_deg", &options->home_lon_deg, "longitude of the take-off place");
  set.Add(s, "home_below_origin_m", &options->home_below_origin_m,
          "how far the take-off place lies below the frame's origin (metres)");
  set.Add(s, "frame_heights", &options->frame_heights,
          "what the model's heights are above: unknown, ellipsoidal or amsl");
  set.Add(s, "height_reference", &options->height_reference,
          "heights of waypoints: relative (to home), amsl or ellipsoidal");
  set.Add(s, "geoid_undulation_m", &options->geoid_undulation_m,
          "geoid over ellipsoid (metres); auto: EGM96 of the package proj-data");
  set.Add(s, "dji_drone", &options->dji_drone, "DJI: 67 M30, 77 M3E, 89 M350, 91 M3D");
  set.Add(s, "dji_payload", &options->dji_payload, "DJI: 52 M30, 66 M3E");
}

}  // namespace colmap_ext
