#include "colmap_ext/dense/epipolar_frame.h"

#include <cmath>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Directions further than this from the plane's axis stretch a planar image too much.
constexpr double kMinPlanarCos = 0.35;
constexpr int kBorderSteps = 16;

// z axis across the baseline, as near as can be to where both cameras look; when they look along
// the baseline, across it by the reference's own vertical.
Eigen::Vector3d AxisAcross(const Eigen::Vector3d& x, const Eigen::Vector3d& forward,
                           const Eigen::Vector3d& vertical) {
  constexpr double kMinSine = 0.05;
  const Eigen::Vector3d across = forward - forward.dot(x) * x;
  if (across.norm() > kMinSine) return across.normalized();
  return (vertical - vertical.dot(x) * x).normalized();
}

}  // namespace

EpipolarFrame::EpipolarFrame(const PinholeCamera& reference, const Rigid3d& reference_from_world,
                             const Rigid3d& partner_from_world)
    : focal_px_(std::sqrt(reference.fx * reference.fy)) {
  const Rigid3d reference_from_partner = reference_from_world * Inverse(partner_from_world);
  const Eigen::Vector3d center = reference_from_partner.translation;
  baseline_ = center.norm();
  if (!(baseline_ > 1e-9)) throw Error("two photos from the same place have no depth");
  const Eigen::Vector3d x = center / baseline_;
  const Eigen::Vector3d partner_forward =
      reference_from_partner.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d forward = (Eigen::Vector3d::UnitZ() + partner_forward) / 2;
  const Eigen::Vector3d z = AxisAcross(x, forward, -Eigen::Vector3d::UnitY());
  rect_from_reference_.row(0) = x;
  rect_from_reference_.row(1) = z.cross(x);
  rect_from_reference_.row(2) = z;
  partner_from_rect_ = reference_from_partner.rotation.inverse().toRotationMatrix() *
                       rect_from_reference_.transpose();
  if (!TryBounds(reference)) {
    is_planar_ = false;
    TryBounds(reference);
  }
}

bool EpipolarFrame::TryBounds(const PinholeCamera& reference) {
  min_position_.setConstant(std::numeric_limits<double>::infinity());
  max_position_ = -min_position_;
  const auto extend = [&](double u, double v) {
    const Eigen::Vector3d ray =
        FromReference(reference.Ray({u * reference.width, v * reference.height})).normalized();
    if (is_planar_ && ray.z() < kMinPlanarCos) return false;
    const Eigen::Vector2d position = Position(ray);
    min_position_ = min_position_.cwiseMin(position);
    max_position_ = max_position_.cwiseMax(position);
    return true;
  };
  // The inside too: the pole of a spherical image may lie in the photo.
  for (int i = 0; i <= kBorderSteps; ++i) {
    for (int k = 0; k <= kBorderSteps; ++k) {
      const double u = static_cast<double>(i) / kBorderSteps;
      const double v = static_cast<double>(k) / kBorderSteps;
      if (!extend(u, v)) return false;
    }
  }
  if (!is_planar_) ExtendToPoles(reference);
  return true;
}

// Around a pole that the photo shows every row begins there.
void EpipolarFrame::ExtendToPoles(const PinholeCamera& reference) {
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d pole = ToReference(Eigen::Vector3d(side, 0, 0));
    if (!(pole.z() > 0) || !reference.Contains(reference.Project(pole))) continue;
    min_position_ = min_position_.cwiseMin(Eigen::Vector2d(side * M_PI_2, -M_PI) * focal_px_);
    max_position_ = max_position_.cwiseMax(Eigen::Vector2d(side * M_PI_2, M_PI) * focal_px_);
  }
}

Eigen::Vector2d EpipolarFrame::Position(const Eigen::Vector3d& d) const {
  if (is_planar_) return {focal_px_ * d.x() / d.z(), focal_px_ * d.y() / d.z()};
  return {focal_px_ * std::atan2(d.x(), std::hypot(d.y(), d.z())),
          focal_px_ * std::atan2(d.y(), d.z())};
}

Eigen::Vector3d EpipolarFrame::Direction(double col, double row) const {
  if (is_planar_) return {col / focal_px_, row / focal_px_, 1.0};
  const double angle = row / focal_px_;
  return {std::tan(col / focal_px_), std::sin(angle), std::cos(angle)};
}

double EpipolarFrame::Slope(double col, double row) const {
  if (!is_planar_) return std::tan(col / focal_px_);
  return col / std::hypot(focal_px_, row);
}

double EpipolarFrame::Column(double slope, double row) const {
  if (!is_planar_) return focal_px_ * std::atan(slope);
  return slope * std::hypot(focal_px_, row);
}

}  // namespace colmap_ext
