// The options of the daemon's flying.
#pragma once

#include <string>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct FlightOptions {
  // A photo is taken when all of these hold (docs/flying.md).
  double settle_distance_m = 0.5;  // from the view, (0, 5]
  double settle_speed_m_s = 0.2;   // (0, 2]
  double settle_yaw_deg = 3;       // (0, 45]
  double aim_tolerance_deg = 1;    // of the gimbal's pitch, (0, 45]
  double settle_timeout_s =
      20;                    // then the target is sent again, and once more the view is given up
  double aim_timeout_s = 6;  // the same for the gimbal
  double aim_wait_s = 1.5;   // where nothing reports the gimbal's attitude
  double capture_timeout_s = 6;   // from the command to the camera's report
  double capture_retry_s = 2.5;   // between attempts (ArduPilot refuses a photo soon after another)
  int capture_attempts = 3;       // [1, 10]
  int max_failures_in_a_row = 3;  // views given up one after another; then the vehicle returns
  double fetch_timeout_s = 60;    // at the end of the mission, for pictures that are on their way

  double link_timeout_s = 5;        // silence after which the link counts as lost, [3, 60]
  double resume_after_link_s = 30;  // a shorter loss goes on by itself when nothing else changed
  double arm_timeout_s = 45;        // ArduPilot refuses for ~16 s after it says that it is ready
  double max_hold_s = 900;          // hovering at the end of the mission, then it returns

  double takeoff_height_m = 5;      // above home, at least, [1, 100]
  double max_sigma_m = 5;           // horizontal, of GPS, before and during flight
  double min_battery_percent = 50;  // to take off
  double reserve_percent = 25;      // must be left after the return
  double percent_per_minute = 6;    // used until a flight's own consumption is known
  double max_home_error_m = 2;      // between the planned and the vehicle's home height

  bool allow_disabled_failsafes = false;  // arm although the vehicle's failsafes are off
  bool upload_fence = true;               // write the mission's fence into the vehicle

  std::string Check() const;
};

// Section "Flight".
void BindOptions(OptionSet& set, FlightOptions* options);

}  // namespace colmap_ext
