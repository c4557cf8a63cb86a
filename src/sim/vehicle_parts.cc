#include "colmap_ext/sim/vehicle_parts.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Vertical fixes are worse by the geometry of the satellites.
Eigen::Vector3d GpsSigma(double horizontal_m) {
  return {horizontal_m, horizontal_m, 1.5 * horizontal_m};
}

double Toward(double value, double target, double most) {
  return value + std::clamp(target - value, -most, most);
}

}  // namespace

SimulatedGps::SimulatedGps(const GpsOptions& options, std::uint64_t seed)
    : options_(options),
      bias_(GpsSigma(options.gps_bias_m), options.gps_bias_time_s, 3 * seed + 1),
      fix_noise_(GpsSigma(options.gps_noise_m), 0.2, 3 * seed + 2),
      // Smoothed by a filter of about two seconds: a third of the noise is left.
      estimate_noise_(GpsSigma(options.gps_noise_m / 3), 2, 3 * seed + 3) {
  ThrowIfInvalid(options.Check());
}

void SimulatedGps::Step(double dt_s) {
  pending_us_ += std::llround(dt_s * 1e6);
  for (; pending_us_ >= kSimulationStepUs; pending_us_ -= kSimulationStepUs) OneStep();
}

void SimulatedGps::OneStep() {
  time_s_ += kSimulationStepS;
  bias_.Step(kSimulationStepS);
  fix_noise_.Step(kSimulationStepS);
  estimate_noise_.Step(kSimulationStepS);
  glitch_time_s_ = IsGlitching() ? glitch_time_s_ + kSimulationStepS : 0;
  if (!IsGlitching() || glitch_time_s_ > kGlitchRejection_s) {
    followed_glitch_ += (glitch_ - followed_glitch_) * (kSimulationStepS / 1.0);
  }
  // Without a fix the estimate drifts away slowly, and comes back with it.
  if (HasFix()) {
    drift_ *= 1 - kSimulationStepS / 2.0;
  } else {
    drift_ += 0.1 * kSimulationStepS * Eigen::Vector3d(1, 0.5, 0);
  }
}

Eigen::Vector3d SimulatedGps::FixError() const {
  return bias_.value() + fix_noise_.value() + glitch_;
}

Eigen::Vector3d SimulatedGps::EstimateError() const {
  return bias_.value() + estimate_noise_.value() + followed_glitch_ + drift_;
}

double SimulatedGps::HorizontalAccuracy() const {
  const double sigma = std::hypot(options_.gps_bias_m, options_.gps_noise_m) + 0.05;
  return IsGlitching() ? 4 * sigma + 2 : sigma;
}

SimulatedBattery::SimulatedBattery(const BatteryOptions& options)
    : options_(options), energy_wh_(options.battery_wh * options.battery_percent / 100) {
  ThrowIfInvalid(options.Check());
}

void SimulatedBattery::Step(double dt_s, const MotionState& motion, bool motors) {
  constexpr double kWattsPerClimb = 0.25;  // of hover power, per m/s
  constexpr double kWattsPerAirSpeed2 = 0.006;
  power_w_ = options_.idle_power_w;
  if (motors && motion.on_ground) power_w_ += 0.15 * options_.hover_power_w;
  if (motors && !motion.on_ground) {
    const double climb = kWattsPerClimb * std::max(0.0, motion.velocity.z());
    const double air = kWattsPerAirSpeed2 * (motion.velocity - motion.wind).squaredNorm();
    power_w_ += options_.hover_power_w * (1 + climb + air);
  }
  const double used_wh = std::min(energy_wh_, power_w_ * dt_s / 3600);
  energy_wh_ -= used_wh;
  consumed_wh_ += used_wh;
}

void SimulatedBattery::SetPercent(double percent) {
  energy_wh_ = options_.battery_wh * std::clamp(percent, 0.0, 100.0) / 100;
}

double SimulatedBattery::voltage() const {
  const double charge = percent() / 100;
  return 4 * (3.45 + 0.65 * charge + 0.1 * charge * charge) - 0.02 * power_w_ / 14.8;
}

SimulatedGimbal::SimulatedGimbal(const GimbalOptions& options, std::uint64_t seed)
    : options_(options),
      jitter_(DegToRad(options.gimbal_jitter_deg) * Eigen::Vector3d::Ones(), 0.3, seed) {
  ThrowIfInvalid(options.Check());
}

void SimulatedGimbal::SetTarget(double pitch_rad, double yaw_rad, bool is_yaw_locked) {
  target_pitch_ =
      std::clamp(pitch_rad, DegToRad(options_.min_pitch_deg), DegToRad(options_.max_pitch_deg));
  target_yaw_ = NormalizeAngle(yaw_rad);
  is_yaw_locked_ = is_yaw_locked;
}

void SimulatedGimbal::Step(double dt_s, double vehicle_yaw_rad) {
  if (is_stuck_) return;
  jitter_.Step(dt_s);
  const double most = DegToRad(options_.gimbal_rate_deg_s) * dt_s;
  const double reach = DegToRad(options_.max_yaw_deg);
  const double yaw = is_yaw_locked_ ? NormalizeAngle(target_yaw_ - vehicle_yaw_rad) : target_yaw_;
  pitch_ = Toward(pitch_, target_pitch_, most);
  yaw_in_body_ = Toward(yaw_in_body_, std::clamp(yaw, -reach, reach), most);
}

double SimulatedGimbal::Heading(double vehicle_yaw_rad) const {
  return NormalizeAngle(vehicle_yaw_rad + YawInBody());
}

}  // namespace colmap_ext
