// The parts of a simulated drone beside its motion: GPS receiver, battery, gimbal.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "colmap_ext/sim/vehicle_motion.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct GpsOptions {
  double gps_bias_m = 0.3;       // sigma of the wandering offset, each horizontal axis, [0, 20]
  double gps_bias_time_s = 120;  // time constant of the wandering, [1, 1e5]
  double gps_noise_m = 0.1;      // sigma of each fix beside that, [0, 20]
  double gps_first_fix_s = 3;    // after power on, [0, 600]

  std::string Check() const;
};
void BindOptions(OptionSet& set, GpsOptions* options);  // section "Drone"

// What the vehicle believes of its position: truth, an offset that wanders (vertical 1.5 times as
// much), and noise. The estimator smooths the noise but cannot see the offset.
class SimulatedGps {
 public:
  SimulatedGps(const GpsOptions& options, std::uint64_t seed);

  void Step(double dt_s);
  // A glitch moves fixes at once; the estimator rejects it for kGlitchRejection_s, then follows.
  void SetGlitch(const Eigen::Vector3d& offset_m) { glitch_ = offset_m; }
  void SetLost(bool is_lost) { is_lost_ = is_lost; }

  bool HasFix() const { return time_s_ >= options_.gps_first_fix_s && !is_lost_; }
  // Whether fix and estimate disagree by more than the estimator would accept.
  bool IsGlitching() const { return (glitch_ - followed_glitch_).norm() > 2; }
  Eigen::Vector3d FixError() const;       // fix minus truth, metres
  Eigen::Vector3d EstimateError() const;  // estimate minus truth, metres
  // One sigma that the receiver reports, metres.
  double HorizontalAccuracy() const;
  double VerticalAccuracy() const { return 1.5 * HorizontalAccuracy(); }
  int Satellites() const { return HasFix() ? 14 : 0; }

  static constexpr double kGlitchRejection_s = 7;

 private:
  void OneStep();

  GpsOptions options_;
  WanderingVector bias_, fix_noise_, estimate_noise_;
  Eigen::Vector3d glitch_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d followed_glitch_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d drift_ = Eigen::Vector3d::Zero();  // while there is no fix
  double glitch_time_s_ = 0, time_s_ = 0;
  bool is_lost_ = false;
  std::int64_t pending_us_ = 0;
};

struct BatteryOptions {
  double battery_wh = 100;       // usable, [1, 1e5]
  double hover_power_w = 150;    // [1, 1e5]
  double idle_power_w = 8;       // electronics, [0, 1e4]
  double battery_percent = 100;  // at the start, [0, 100]

  std::string Check() const;
};
void BindOptions(OptionSet& set, BatteryOptions* options);  // section "Drone"

class SimulatedBattery {
 public:
  explicit SimulatedBattery(const BatteryOptions& options);

  // Power: idle, and in flight hover plus what climbing and speed through the air need.
  void Step(double dt_s, const MotionState& motion, bool motors);
  void SetPercent(double percent);

  double percent() const { return 100 * energy_wh_ / options_.battery_wh; }
  double power_w() const { return power_w_; }
  double voltage() const;  // of four cells
  double current() const { return power_w_ / voltage(); }
  double consumed_wh() const { return consumed_wh_; }
  // Seconds of hover that are left.
  double TimeLeft() const { return 3600 * energy_wh_ / options_.hover_power_w; }

 private:
  BatteryOptions options_;
  double energy_wh_, consumed_wh_ = 0, power_w_ = 0;
};

struct GimbalOptions {
  double gimbal_rate_deg_s = 60;                   // of each axis, (0, 720]
  double gimbal_jitter_deg = 0.03;                 // sigma, [0, 5]
  double min_pitch_deg = -95, max_pitch_deg = 30;  // [-180, 180]
  double max_yaw_deg = 160;                        // to either side of the nose, [0, 180]

  std::string Check() const;
};
void BindOptions(OptionSet& set, GimbalOptions* options);  // section "Drone"

// Pitch is held level with the horizon; yaw follows the nose, or a heading when locked. No roll.
class SimulatedGimbal {
 public:
  SimulatedGimbal(const GimbalOptions& options, std::uint64_t seed);

  // Angles outside the range are clamped. `yaw_rad` is relative to the nose, or a heading when
  // `is_yaw_locked`.
  void SetTarget(double pitch_rad, double yaw_rad, bool is_yaw_locked);
  void SetStuck(bool is_stuck) { is_stuck_ = is_stuck; }
  void Step(double dt_s, double vehicle_yaw_rad);

  double pitch_rad() const { return pitch_ + jitter_.value().x(); }
  double YawInBody() const { return yaw_in_body_ + jitter_.value().y(); }
  double Heading(double vehicle_yaw_rad) const;
  bool is_yaw_locked() const { return is_yaw_locked_; }
  bool is_stuck() const { return is_stuck_; }

 private:
  GimbalOptions options_;
  double target_pitch_ = 0, target_yaw_ = 0;
  bool is_yaw_locked_ = false, is_stuck_ = false;
  double pitch_ = 0, yaw_in_body_ = 0;
  WanderingVector jitter_;
};

}  // namespace colmap_ext
