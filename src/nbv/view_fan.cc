#include "nbv/view_fan.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {

ViewFan::ViewFan(const SearchContext& context, const std::vector<ViewDirection>& directions)
    : context_(context),
      range_squared_m2_(std::pow(UsefulRange(context), 2)),
      min_cos_incidence_(std::cos(DegToRad(context.options.visibility.max_incidence_deg))) {
  const double border_px = context.options.visibility.border_px;
  const PinholeCamera& camera = context.camera();
  min_x_ = camera.Ray({border_px, 0}).x();
  max_x_ = camera.Ray({camera.width - border_px, 0}).x();
  min_y_ = camera.Ray({0, border_px}).y();
  max_y_ = camera.Ray({0, camera.height - border_px}).y();
  max_abs_x_ = std::max(std::abs(min_x_), std::abs(max_x_));
  for (std::size_t k = 0; k < directions.size(); ++k) {
    const double yaw = directions[k].yaw_rad;
    auto heading = std::find_if(headings_.begin(), headings_.end(),
                                [&](const Heading& other) { return other.yaw_rad == yaw; });
    if (heading == headings_.end()) {
      heading = headings_.insert(headings_.end(), {yaw, std::sin(yaw), std::cos(yaw), {}});
    }
    const double pitch = directions[k].pitch_rad;
    heading->tilts.push_back({std::sin(pitch), std::cos(pitch), k});
  }
}

bool ViewFan::IsInReach(const Eigen::Vector3d& position, const Eigen::Vector3d& point,
                        const Eigen::Vector3d& normal) const {
  const Eigen::Vector3d offset = point - position;
  const double squared_distance = offset.squaredNorm();
  if (squared_distance > range_squared_m2_) return false;
  const double facing = -normal.dot(offset);
  return facing > 0 && facing >= min_cos_incidence_ * std::sqrt(squared_distance);
}

bool ViewFan::LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& point,
                     const Eigen::Vector3d& normal) {
  seen_.clear();
  if (!IsInReach(position, point, normal)) return false;
  const Eigen::Vector3d offset = point - position;
  const double facing = -normal.dot(offset);
  const double numerator = context_.camera().fx * context_.camera().fy * facing;
  for (const Heading& heading : headings_) {
    const double forward = offset.x() * heading.sin_yaw + offset.y() * heading.cos_yaw;
    const double right = offset.x() * heading.cos_yaw - offset.y() * heading.sin_yaw;
    // The depth at any pitch is at most the distance in the vertical plane of the heading.
    const double max_depth_squared = forward * forward + offset.z() * offset.z();
    if (right * right > max_abs_x_ * max_abs_x_ * max_depth_squared) continue;
    for (const Tilt& tilt : heading.tilts) {
      const double depth = forward * tilt.cos_pitch + offset.z() * tilt.sin_pitch;
      if (depth <= 0 || right < min_x_ * depth || right > max_x_ * depth) continue;
      const double down = forward * tilt.sin_pitch - offset.z() * tilt.cos_pitch;
      if (down < min_y_ * depth || down > max_y_ * depth) continue;
      const double ratio = numerator / (depth * depth * depth);
      if (ratio >= context_.min_projection_ratio) seen_.emplace_back(tilt.direction, ratio);
    }
  }
  return !seen_.empty();
}

}  // namespace colmap_ext
