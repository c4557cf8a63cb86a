#include <array>
#include <cstdio>

#include "colmap_ext/flight/flight_options.h"

namespace colmap_ext {

std::string FlightOptions::Check() const {
  struct Range {
    const char* name;
    double value, low, high;
  };
  const std::array ranges = {
      Range{"settle_distance_m", settle_distance_m, 0.01, 5},
      Range{"settle_speed_m_s", settle_speed_m_s, 0.01, 2},
      Range{"settle_yaw_deg", settle_yaw_deg, 0.1, 45},
      Range{"aim_tolerance_deg", aim_tolerance_deg, 0.1, 45},
      Range{"settle_timeout_s", settle_timeout_s, 1, 300},
      Range{"aim_timeout_s", aim_timeout_s, 0.5, 60},
      Range{"aim_wait_s", aim_wait_s, 0, 60},
      Range{"capture_timeout_s", capture_timeout_s, 0.5, 60},
      Range{"capture_retry_s", capture_retry_s, 0, 60},
      Range{"capture_attempts", static_cast<double>(capture_attempts), 1, 10},
      Range{"max_failures_in_a_row", static_cast<double>(max_failures_in_a_row), 1, 100},
      Range{"fetch_timeout_s", fetch_timeout_s, 0, 3600},
      Range{"link_timeout_s", link_timeout_s, 3, 60},
      Range{"resume_after_link_s", resume_after_link_s, 0, 3600},
      Range{"arm_timeout_s", arm_timeout_s, 1, 300},
      Range{"max_hold_s", max_hold_s, 0, 86400},
      Range{"takeoff_height_m", takeoff_height_m, 0.3, 100},
      Range{"max_sigma_m", max_sigma_m, 0.01, 100},
      Range{"min_battery_percent", min_battery_percent, 0, 100},
      Range{"reserve_percent", reserve_percent, 0, 90},
      Range{"percent_per_minute", percent_per_minute, 0.01, 100},
      Range{"max_home_error_m", max_home_error_m, 0.1, 100},
  };
  for (const Range& range : ranges) {
    if (range.value >= range.low && range.value <= range.high) continue;
    char text[160];
    std::snprintf(text, sizeof text, "Flight.%s must be from %g to %g", range.name, range.low,
                  range.high);
    return text;
  }
  return "";
}

void BindOptions(OptionSet& set, FlightOptions* options) {
  const std::string section = "Flight";
  set.Add(section, "settle_distance_m", &options->settle_distance_m,
          "a photo is taken when the vehicle is so near to its view [m, 0.01 … 5]");
  set.Add(section, "settle_speed_m_s", &options->settle_speed_m_s,
          "... and slower than this [m/s, 0.01 … 2]");
  set.Add(section, "settle_yaw_deg", &options->settle_yaw_deg,
          "... and so near to its heading [degrees, 0.1 … 45]");
  set.Add(section, "aim_tolerance_deg", &options->aim_tolerance_deg,
          "... and the gimbal so near to its pitch [degrees, 0.1 … 45]");
  set.Add(section, "settle_timeout_s", &options->settle_timeout_s,
          "time to get there; then once more, then the view is given up [s, 1 … 300]");
  set.Add(section, "aim_timeout_s", &options->aim_timeout_s,
          "the same for the gimbal [s, 0.5 … 60]");
  set.Add(section, "aim_wait_s", &options->aim_wait_s,
          "wait where nothing reports the gimbal's attitude [s, 0 … 60]");
  set.Add(section, "capture_timeout_s", &options->capture_timeout_s,
          "wait for the camera's report [s, 0.5 … 60]");
  set.Add(section, "capture_retry_s", &options->capture_retry_s,
          "wait before a refused photo is asked for again [s, 0 … 60]");
  set.Add(section, "capture_attempts", &options->capture_attempts,
          "then the view is given up [1 … 10]");
  set.Add(section, "max_failures_in_a_row", &options->max_failures_in_a_row,
          "views given up one after another; then the vehicle returns [1 … 100]");
  set.Add(section, "fetch_timeout_s", &options->fetch_timeout_s,
          "at the end, wait for pictures that are on their way [s, 0 … 3600]");
  set.Add(section, "link_timeout_s", &options->link_timeout_s,
          "silence after which the link counts as lost [s, 3 … 60]");
  set.Add(section, "resume_after_link_s", &options->resume_after_link_s,
          "a shorter loss goes on by itself when nothing else changed [s, 0 … 3600]");
  set.Add(section, "arm_timeout_s", &options->arm_timeout_s,
          "arming is tried again for so long [s, 1 … 300]");
  set.Add(section, "max_hold_s", &options->max_hold_s,
          "hovering for more views at the end, then it returns [s, 0 … 86400]");
  set.Add(section, "takeoff_height_m", &options->takeoff_height_m,
          "above home, at least [m, 0.3 … 100]");
  set.Add(section, "max_sigma_m", &options->max_sigma_m,
          "horizontal accuracy of GPS that is good enough to fly [m, 0.01 … 100]");
  set.Add(section, "min_battery_percent", &options->min_battery_percent,
          "to take off [%, 0 … 100]");
  set.Add(section, "reserve_percent", &options->reserve_percent,
          "must be left after the return [%, 0 … 90]");
  set.Add(section, "percent_per_minute", &options->percent_per_minute,
          "consumption until the flight's own is known [%/min, 0.01 … 100]");
  set.Add(section, "max_home_error_m", &options->max_home_error_m,
          "between the planned height of the take-off place and the vehicle's [m, 0.1 … 100]");
  set.Add(section, "allow_disabled_failsafes", &options->allow_disabled_failsafes,
          "arm although failsafes of the vehicle are off");
  set.Add(section, "upload_fence", &options->upload_fence,
          "write the mission's fence into the vehicle");
}

}  // namespace colmap_ext
