#include "colmap_ext/sim/vehicle_motion.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kGravity = 9.81;        // m/s²
constexpr double kDrag = 0.12;           // 1/s: 8 m/s of wind push with 1 m/s²
constexpr double kJerk = 25;             // m/s³: full thrust angle in about 0.1 s
constexpr double kVelocityGain = 2.5;    // 1/s
constexpr double kPositionGain = 1.0;    // 1/s, near the target
constexpr double kBrakingShare = 0.45;   // of the acceleration limit that braking plans with
constexpr double kObserverTime_s = 0.3;  // of the disturbance
constexpr double kGustTime_s = 2.5;      // of the gusts
constexpr double kMaxDisturbance = 3;    // m/s² that the controller removes
constexpr double kHoldClimb_m_s = 0.01;  // climb rates below this hold the height

Eigen::Vector3d GustSigma(const WindOptions& wind) {
  return wind.gust_m_s * Eigen::Vector3d(1, 1, 0.3);
}

Eigen::Vector3d MeanWind(const WindOptions& wind) {
  const double from = DegToRad(wind.from_deg);
  return -wind.mean_m_s * Eigen::Vector3d(std::sin(from), std::cos(from), 0);
}

Eigen::Vector3d Limited(const Eigen::Vector3d& v, double length) {
  const double norm = v.norm();
  return norm > length ? Eigen::Vector3d(v * (length / norm)) : v;
}

// The greatest speed from which `acceleration` still stops within `distance`, linear at the end.
double StoppingSpeed(double distance, double acceleration) {
  return std::min(kPositionGain * distance, std::sqrt(2 * acceleration * distance));
}

}  // namespace

double GaussianStream::Next() {
  const auto unit = [&] { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(unit()));
  return radius * std::cos(2 * M_PI * unit());
}

WanderingVector::WanderingVector(const Eigen::Vector3d& sigma, double tau_s, std::uint64_t seed)
    : sigma_(sigma), tau_s_(tau_s), noise_(seed) {
  unit_ = noise_.NextVector();
  value_ = sigma_.cwiseProduct(unit_);
}

const Eigen::Vector3d& WanderingVector::Step(double dt_s) {
  const double keep = std::exp(-dt_s / tau_s_);
  unit_ = keep * unit_ + std::sqrt(1 - keep * keep) * noise_.NextVector();
  value_ = sigma_.cwiseProduct(unit_);
  return value_;
}

void WanderingVector::SetSigma(const Eigen::Vector3d& sigma) {
  sigma_ = sigma;
  value_ = sigma_.cwiseProduct(unit_);
}

VehicleMotion::VehicleMotion(const VehicleMotionOptions& options, const Eigen::Vector3d& start,
                             double yaw_rad, std::uint64_t seed, GroundHeight ground)
    : options_(options),
      ground_(std::move(ground)),
      gusts_(GustSigma(options.wind), kGustTime_s, seed) {
  ThrowIfInvalid(options.Check());
  if (!ground_) ground_ = [z = start.z()](const Eigen::Vector3d&) { return z; };
  state_.position = start;
  state_.position.z() = ground_(start);
  state_.yaw_rad = NormalizeAngle(yaw_rad);
  target_.position = state_.position;
  target_.yaw_rad = state_.yaw_rad;
}

void VehicleMotion::SetWind(const WindOptions& wind) {
  ThrowIfInvalid(wind.Check());
  options_.wind = wind;
  gusts_.SetSigma(GustSigma(wind));
}

void VehicleMotion::Step(double dt_s, const Eigen::Vector3d& estimate_error) {
  pending_us_ += std::llround(dt_s * 1e6);
  for (; pending_us_ >= kSimulationStepUs; pending_us_ -= kSimulationStepUs) {
    OneStep(estimate_error);
  }
}

void VehicleMotion::OneStep(const Eigen::Vector3d& estimate_error) {
  state_.wind = MeanWind(options_.wind) + gusts_.Step(kSimulationStepS);
  if (target_.motors) {
    StepVelocity(WantedVelocity(state_.position + estimate_error));
    StepYaw();
  } else {
    thrust_.setZero();
    disturbance_.setZero();
    state_.yaw_rate_rad_s = 0;
    const Eigen::Vector3d fall(0, 0, -kGravity);
    state_.acceleration = state_.on_ground ? Eigen::Vector3d(0, 0, 0) : fall;
  }
  state_.velocity += state_.acceleration * kSimulationStepS;
  state_.position += state_.velocity * kSimulationStepS;
  StepGround();
  // Thrust leans into the acceleration: nose down to go forward, right side down to go right.
  const double s = std::sin(state_.yaw_rad), c = std::cos(state_.yaw_rad);
  const double forward = s * thrust_.x() + c * thrust_.y();
  const double right = c * thrust_.x() - s * thrust_.y();
  state_.pitch_rad = std::atan2(-forward, kGravity);
  state_.roll_rad = std::atan2(right, kGravity);
}

Eigen::Vector3d VehicleMotion::WantedVelocity(const Eigen::Vector3d& estimated_position) const {
  const double speed = std::min(options_.max_speed_m_s, target_.speed_m_s);
  const double climb = std::min(options_.max_climb_m_s, target_.climb_m_s);
  const double descent = std::min(options_.max_descent_m_s, target_.descent_m_s);
  Eigen::Vector3d error = target_.position - estimated_position;
  const bool has_rate = target_.climb_rate_m_s.has_value();
  if (has_rate) error.z() = 0;
  const double distance = error.norm();
  Eigen::Vector3d wanted = Eigen::Vector3d::Zero();
  if (distance > 1e-9) {
    const Eigen::Vector3d along = error / distance;
    double most = StoppingSpeed(distance, kBrakingShare * options_.max_acceleration_m_s2);
    const double horizontal = along.head<2>().norm();
    if (horizontal > 1e-9) most = std::min(most, speed / horizontal);
    if (along.z() > 1e-9) most = std::min(most, climb / along.z());
    if (along.z() < -1e-9) most = std::min(most, -descent / along.z());
    wanted = most * along;
  }
  if (has_rate) wanted.z() = std::clamp(*target_.climb_rate_m_s, -descent, climb);
  return wanted;
}

void VehicleMotion::StepVelocity(const Eigen::Vector3d& wanted) {
  // Limited as a whole, so that it keeps its direction: paths stay straight.
  const Eigen::Vector3d total =
      Limited(kVelocityGain * (wanted - state_.velocity), options_.max_acceleration_m_s2);
  thrust_ += Limited(total - disturbance_ - thrust_, kJerk * kSimulationStepS);
  const Eigen::Vector3d drag = kDrag * (state_.wind - state_.velocity);
  disturbance_ += (drag - disturbance_) * (kSimulationStepS / kObserverTime_s);
  disturbance_ = Limited(disturbance_, kMaxDisturbance);
  state_.acceleration = thrust_ + drag;
  if (state_.on_ground && wanted.z() <= kHoldClimb_m_s) {
    state_.acceleration.setZero();  // its weight holds it
    thrust_.setZero();
  }
}

void VehicleMotion::StepYaw() {
  if (state_.on_ground) {
    state_.yaw_rate_rad_s = 0;
    return;
  }
  const double error = NormalizeAngle(target_.yaw_rad - state_.yaw_rad);
  const double max_rate = DegToRad(options_.max_yaw_rate_deg_s);
  const double max_accel = DegToRad(options_.max_yaw_accel_deg_s2);
  const double size = std::min(
      {max_rate, 3 * std::abs(error), std::sqrt(2 * kBrakingShare * max_accel * std::abs(error))});
  const double wanted = std::copysign(size, error);
  const double change = std::clamp(wanted - state_.yaw_rate_rad_s, -max_accel * kSimulationStepS,
                                   max_accel * kSimulationStepS);
  state_.yaw_rate_rad_s = std::clamp(state_.yaw_rate_rad_s + change, -max_rate, max_rate);
  state_.yaw_rad = NormalizeAngle(state_.yaw_rad + state_.yaw_rate_rad_s * kSimulationStepS);
}

void VehicleMotion::StepGround() {
  const double ground = ground_(state_.position);
  const bool was_on_ground = state_.on_ground;
  state_.on_ground = state_.position.z() <= ground + 1e-6;
  if (!state_.on_ground) return;
  if (!was_on_ground) {
    state_.impact_speed_m_s = std::max(state_.impact_speed_m_s, -state_.velocity.z());
  }
  state_.position.z() = ground;
  if (state_.velocity.z() <= 0) state_.velocity.setZero();
}

}  // namespace colmap_ext
