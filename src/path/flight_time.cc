#include "colmap_ext/path/flight_time.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

double TimeFor(double distance_m, double speed_m_s, double acceleration_m_s2) {
  if (distance_m >= speed_m_s * speed_m_s / acceleration_m_s2) {
    return distance_m / speed_m_s + speed_m_s / acceleration_m_s2;
  }
  return 2 * std::sqrt(distance_m / acceleration_m_s2);
}

}  // namespace

double TimeBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   const PathOptions& options) {
  const Eigen::Vector3d way = to - from;
  const double vertical_speed = way.z() > 0 ? options.climb_speed_m_s : options.descent_speed_m_s;
  return std::max(TimeFor(way.head<2>().norm(), options.speed_m_s, options.acceleration_m_s2),
                  TimeFor(std::abs(way.z()), vertical_speed, options.acceleration_m_s2));
}

double EstimateDuration(const std::vector<Waypoint>& waypoints, const PathOptions& options) {
  double duration_s = 0;
  double yaw_rad = waypoints.empty() ? 0 : waypoints.front().direction.yaw_rad;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (i > 0) {
      duration_s += TimeBetween(waypoints[i - 1].position, waypoints[i].position, options);
    }
    if (waypoints[i].view_id < 0) continue;
    const double turn_rad = std::abs(NormalizeAngle(waypoints[i].direction.yaw_rad - yaw_rad));
    duration_s += RadToDeg(turn_rad) / options.yaw_rate_deg_s + options.hover_s;
    yaw_rad = waypoints[i].direction.yaw_rad;
  }
  return duration_s;
}

}  // namespace colmap_ext
