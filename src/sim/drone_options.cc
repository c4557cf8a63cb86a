#include <algorithm>
#include <initializer_list>
#include <string>

#include "colmap_ext/sim/autopilot.h"
#include "colmap_ext/sim/vehicle_motion.h"
#include "colmap_ext/sim/vehicle_parts.h"

namespace colmap_ext {
namespace {

const char* const kSection = "Drone";

struct Range {
  const char* name;
  double value, low, high;
  bool is_low_allowed = true;
};

// The first value outside its range, said in words; NaN is outside of every range.
std::string FirstOutside(std::initializer_list<Range> ranges) {
  for (const Range& range : ranges) {
    const bool is_inside =
        range.value <= range.high &&
        (range.is_low_allowed ? range.value >= range.low : range.value > range.low);
    if (is_inside) continue;
    const auto text = [](double number) {
      std::string digits = std::to_string(number);
      digits.erase(digits.find_last_not_of('0') + 1);
      if (digits.back() == '.') digits.pop_back();
      return digits;
    };
    return std::string(kSection) + "." + range.name + " must be in " +
           (range.is_low_allowed ? "[" : "(") + text(range.low) + ", " + text(range.high) + "]";
  }
  return "";
}

}  // namespace

std::string WindOptions::Check() const {
  return FirstOutside({{"wind_m_s", mean_m_s, 0, 20},
                       {"wind_from_deg", from_deg, -360, 360},
                       {"gust_m_s", gust_m_s, 0, 10}});
}

std::string VehicleMotionOptions::Check() const {
  const std::string complaint =
      FirstOutside({{"max_speed_m_s", max_speed_m_s, 0, 30, false},
                    {"max_climb_m_s", max_climb_m_s, 0, 10, false},
                    {"max_descent_m_s", max_descent_m_s, 0, 10, false},
                    {"max_acceleration_m_s2", max_acceleration_m_s2, 0, 9, false},
                    {"max_yaw_rate_deg_s", max_yaw_rate_deg_s, 0, 360, false},
                    {"max_yaw_accel_deg_s2", max_yaw_accel_deg_s2, 0, 2000, false}});
  return complaint.empty() ? wind.Check() : complaint;
}

void BindOptions(OptionSet& set, VehicleMotionOptions* o) {
  set.Add(kSection, "max_speed_m_s", &o->max_speed_m_s, "horizontal speed limit (m/s, (0, 30])");
  set.Add(kSection, "max_climb_m_s", &o->max_climb_m_s, "limit of climbing (m/s, (0, 10])");
  set.Add(kSection, "max_descent_m_s", &o->max_descent_m_s, "limit of descending (m/s, (0, 10])");
  set.Add(kSection, "max_acceleration_m_s2", &o->max_acceleration_m_s2,
          "limit of acceleration (m/s², (0, 9])");
  set.Add(kSection, "max_yaw_rate_deg_s", &o->max_yaw_rate_deg_s,
          "limit of turning (degrees/s, (0, 360])");
  set.Add(kSection, "max_yaw_accel_deg_s2", &o->max_yaw_accel_deg_s2,
          "limit of its change (degrees/s², (0, 2000])");
  set.Add(kSection, "wind_m_s", &o->wind.mean_m_s, "mean wind (m/s, [0, 20])");
  set.Add(kSection, "wind_from_deg", &o->wind.from_deg,
          "where it comes from, clockwise from north (degrees, [-360, 360])");
  set.Add(kSection, "gust_m_s", &o->wind.gust_m_s, "sigma of gusts (m/s, [0, 10])");
}

std::string GpsOptions::Check() const {
  return FirstOutside({{"gps_bias_m", gps_bias_m, 0, 20},
                       {"gps_bias_time_s", gps_bias_time_s, 1, 1e5},
                       {"gps_noise_m", gps_noise_m, 0, 20},
                       {"gps_first_fix_s", gps_first_fix_s, 0, 600}});
}

void BindOptions(OptionSet& set, GpsOptions* o) {
  set.Add(kSection, "gps_bias_m", &o->gps_bias_m,
          "sigma of the wandering offset of GPS, each horizontal axis (m, [0, 20])");
  set.Add(kSection, "gps_bias_time_s", &o->gps_bias_time_s,
          "time in which that offset changes (s, [1, 1e5])");
  set.Add(kSection, "gps_noise_m", &o->gps_noise_m, "sigma of each fix beside it (m, [0, 20])");
  set.Add(kSection, "gps_first_fix_s", &o->gps_first_fix_s,
          "from power on to the first fix (s, [0, 600])");
}

std::string BatteryOptions::Check() const {
  return FirstOutside({{"battery_wh", battery_wh, 1, 1e5},
                       {"hover_power_w", hover_power_w, 1, 1e5},
                       {"idle_power_w", idle_power_w, 0, 1e4},
                       {"battery_percent", battery_percent, 0, 100}});
}

void BindOptions(OptionSet& set, BatteryOptions* o) {
  set.Add(kSection, "battery_wh", &o->battery_wh, "usable energy of the battery (Wh, [1, 1e5])");
  set.Add(kSection, "hover_power_w", &o->hover_power_w, "power of hovering (W, [1, 1e5])");
  set.Add(kSection, "idle_power_w", &o->idle_power_w, "power of the electronics (W, [0, 1e4])");
  set.Add(kSection, "battery_percent", &o->battery_percent, "charge at the start (%, [0, 100])");
}

std::string GimbalOptions::Check() const {
  const std::string complaint =
      FirstOutside({{"gimbal_rate_deg_s", gimbal_rate_deg_s, 0, 720, false},
                    {"gimbal_jitter_deg", gimbal_jitter_deg, 0, 5},
                    {"gimbal_min_pitch_deg", min_pitch_deg, -180, 180},
                    {"gimbal_max_pitch_deg", max_pitch_deg, -180, 180},
                    {"gimbal_max_yaw_deg", max_yaw_deg, 0, 180}});
  if (!complaint.empty()) return complaint;
  if (min_pitch_deg > max_pitch_deg) {
    return "Drone.gimbal_min_pitch_deg must not be above Drone.gimbal_max_pitch_deg";
  }
  return "";
}

void BindOptions(OptionSet& set, GimbalOptions* o) {
  set.Add(kSection, "gimbal_rate_deg_s", &o->gimbal_rate_deg_s,
          "speed of each axis (degrees/s, (0, 720])");
  set.Add(kSection, "gimbal_jitter_deg", &o->gimbal_jitter_deg,
          "sigma of what it shakes (degrees, [0, 5])");
  set.Add(kSection, "gimbal_min_pitch_deg", &o->min_pitch_deg, "lowest pitch (degrees)");
  set.Add(kSection, "gimbal_max_pitch_deg", &o->max_pitch_deg, "highest pitch (degrees)");
  set.Add(kSection, "gimbal_max_yaw_deg", &o->max_yaw_deg,
          "reach to either side of the nose (degrees, [0, 180])");
}

std::string AutopilotOptions::Check() const {
  const auto one_of = [](const std::string& value, std::initializer_list<const char*> allowed) {
    return std::any_of(allowed.begin(), allowed.end(),
                       [&](const char* each) { return value == each; });
  };
  if (!one_of(failsafes, {"stock", "safe"})) return "Drone.failsafes must be stock or safe";
  if (!one_of(gimbal_protocol, {"v2", "mount", "none"})) {
    return "Drone.gimbal_protocol must be v2, mount or none";
  }
  if (!one_of(camera_protocol, {"v2", "trigger"})) {
    return "Drone.camera_protocol must be v2 or trigger";
  }
  if (!one_of(file_url, {"none", "http", "mftp"})) {
    return "Drone.file_url must be none, http or mftp";
  }
  if (system_id < 1 || system_id > 255) return "the system id must be in [1, 255]";
  const std::string complaint = FirstOutside({{"undulation_m", undulation_m, -120, 120},
                                              {"home_yaw_deg", home_yaw_deg, -360, 360},
                                              {"prearm_ready_s", prearm_ready_s, 0, 600},
                                              {"estimator_ready_s", estimator_ready_s, 0, 600},
                                              {"capture_spacing_s", capture_spacing_s, 0, 60}});
  if (!complaint.empty()) return complaint;
  for (const std::string& part : {motion.Check(), gps.Check(), battery.Check(), gimbal.Check()}) {
    if (!part.empty()) return part;
  }
  return "";
}

void BindOptions(OptionSet& set, AutopilotOptions* o) {
  set.Add(kSection, "failsafes", &o->failsafes,
          "stock: those of a new vehicle, most of them off; safe: those that a flight needs");
  set.Add(kSection, "parameters", &o->parameters, "further parameters, NAME=VALUE,NAME=VALUE");
  set.Add(kSection, "gimbal_protocol", &o->gimbal_protocol,
          "v2, mount (only MOUNT_CONTROL) or none");
  set.Add(kSection, "camera_protocol", &o->camera_protocol, "v2 or trigger (only DIGICAM_CONTROL)");
  set.Add(kSection, "file_url", &o->file_url, "what a picture's report says: none, http or mftp");
  set.Add(kSection, "undulation_m", &o->undulation_m,
          "of the geoid: ellipsoidal height minus AMSL (m, [-120, 120])");
  set.Add(kSection, "home_yaw_deg", &o->home_yaw_deg,
          "where the nose points at the start, clockwise from north (degrees)");
  set.Add(kSection, "prearm_ready_s", &o->prearm_ready_s,
          "from power on until it says that it could arm (s, [0, 600])");
  set.Add(kSection, "estimator_ready_s", &o->estimator_ready_s,
          "until its position is good; ArduPilot: 16 s more (s, [0, 600])");
  set.Add(kSection, "capture_spacing_s", &o->capture_spacing_s,
          "ArduPilot: least time between pictures (s, [0, 60])");
  BindOptions(set, &o->motion);
  BindOptions(set, &o->gps);
  BindOptions(set, &o->battery);
  BindOptions(set, &o->gimbal);
}

}  // namespace colmap_ext
