// How a simulated quadrotor moves: limits, wind, ground, and a controller that flies to a target.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

// The steps of everything that moves; results do not depend on how time is cut into Step() calls.
inline constexpr std::int64_t kSimulationStepUs = 10'000;
inline constexpr double kSimulationStepS = static_cast<double>(kSimulationStepUs) * 1e-6;

// Independent standard normal numbers, the same on every machine (Box and Muller; the standard
// library's normal_distribution differs between implementations).
class GaussianStream {
 public:
  explicit GaussianStream(std::uint64_t seed) : engine_(seed) {}
  double Next();
  Eigen::Vector3d NextVector() { return {Next(), Next(), Next()}; }

 private:
  std::mt19937_64 engine_;
};

// First-order Gauss-Markov process a vector: wanders about 0 with `sigma` and time constant
// `tau_s`.
class WanderingVector {
 public:
  // Starts at a random state of the process.
  WanderingVector(const Eigen::Vector3d& sigma, double tau_s, std::uint64_t seed);
  const Eigen::Vector3d& Step(double dt_s);
  const Eigen::Vector3d& value() const { return value_; }
  void SetSigma(const Eigen::Vector3d& sigma);  // the present state is scaled with it

 private:
  Eigen::Vector3d sigma_, unit_, value_;
  double tau_s_;
  GaussianStream noise_;
};

struct WindOptions {
  double mean_m_s = 1;    // [0, 20]
  double from_deg = 250;  // where it comes from, clockwise from north, [-360, 360]
  double gust_m_s = 0.5;  // sigma of the gusts, [0, 10]; vertical ones have 0.3 of it

  std::string Check() const;
};

struct VehicleMotionOptions {
  double max_speed_m_s = 8;           // horizontal, (0, 30]
  double max_climb_m_s = 3;           // (0, 10]
  double max_descent_m_s = 1.5;       // (0, 10]
  double max_acceleration_m_s2 = 3;   // beside gravity, (0, 9]
  double max_yaw_rate_deg_s = 60;     // (0, 360]
  double max_yaw_accel_deg_s2 = 120;  // (0, 2000]
  WindOptions wind;

  std::string Check() const;
};
void BindOptions(OptionSet& set, VehicleMotionOptions* options);  // section "Drone"

// What the vehicle is asked to do.
struct MotionTarget {
  bool motors = false;                                 // off: it stands, or falls
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world (ENU), metres
  // Instead of position.z(): climb (descend when negative) at this rate, m/s.
  std::optional<double> climb_rate_m_s;
  // Limits of this target beside those of the options, m/s.
  double speed_m_s = 1e9, climb_m_s = 1e9, descent_m_s = 1e9;
  double yaw_rad = 0;  // clockwise from north
};

struct MotionState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // world (ENU), metres
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // m/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // m/s²
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();          // velocity of the air, m/s
  double yaw_rad = 0, yaw_rate_rad_s = 0;                  // clockwise from north, (-pi, pi]
  double roll_rad = 0, pitch_rad = 0;  // right side down, nose up (as in MAVLink)
  bool on_ground = true;
  double impact_speed_m_s = 0;  // greatest downward speed at which it ever met the ground
};

// A point mass under a thrust that is bounded in acceleration and jerk, with linear drag toward
// the wind. The controller sees the position with an error that the caller supplies, removes the
// drag by a disturbance observer, and flies straight lines: speed along the error vector, bounded
// so that the vehicle can stop (v² = 2 a e), scaled by whichever limit binds first.
class VehicleMotion {
 public:
  // Height of the surface below a position, metres (z of the world).
  using GroundHeight = std::function<double(const Eigen::Vector3d& position)>;

  // Stands on the ground at (x, y) of `start`. Throws UsageError for invalid options.
  VehicleMotion(const VehicleMotionOptions& options, const Eigen::Vector3d& start, double yaw_rad,
                std::uint64_t seed, GroundHeight ground = nullptr);  // nullptr: level at start.z()

  void SetTarget(const MotionTarget& target) { target_ = target; }
  void SetWind(const WindOptions& wind);
  // `estimate_error`: what the position estimate is off by (estimate minus truth), metres.
  void Step(double dt_s, const Eigen::Vector3d& estimate_error = Eigen::Vector3d::Zero());

  const MotionState& state() const { return state_; }
  const MotionTarget& target() const { return target_; }
  const VehicleMotionOptions& options() const { return options_; }

 private:
  void OneStep(const Eigen::Vector3d& estimate_error);
  Eigen::Vector3d WantedVelocity(const Eigen::Vector3d& estimated_position) const;
  void StepVelocity(const Eigen::Vector3d& wanted);
  void StepYaw();
  void StepGround();

  VehicleMotionOptions options_;
  GroundHeight ground_;
  MotionTarget target_;
  MotionState state_;
  WanderingVector gusts_;
  Eigen::Vector3d thrust_ = Eigen::Vector3d::Zero();       // acceleration beside gravity, m/s²
  Eigen::Vector3d disturbance_ = Eigen::Vector3d::Zero();  // observed, m/s²
  std::int64_t pending_us_ = 0;
};

}  // namespace colmap_ext
