#include "nbv/search_context.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

// More than the path planner's margin of proof, so that it can prove to reach what is planned here.
constexpr double kClearanceMargin_m = 0.05;

}  // namespace

std::string WhyNotFree(const SearchContext& context, const Eigen::Vector3d& position) {
  const NextBestViewOptions& options = context.options;
  if (position.z() < context.lowest_altitude_m) return "below the lowest altitude";
  if (options.max_altitude_m != 0 && position.z() > options.max_altitude_m) {
    return "above the highest altitude";
  }
  const FlightLimits* limits = context.input.limits;
  if (limits != nullptr && !limits->Allows(position, context.input.limits_margin_m)) {
    const std::string reason = limits->WhyNot(position);
    return reason.empty() ? "too near to a limit of flight" : reason;
  }
  const double least_m = options.safe_distance_m + kClearanceMargin_m;
  const double look_m = std::max(least_m + 1, options.max_distance_m + 1);
  const double distance_m = context.engine.ray_scene().DistanceToSurface(position, look_m);
  if (distance_m < least_m) return "nearer to the surface than the safe distance";
  if (options.max_distance_m != 0 && distance_m > options.max_distance_m) {
    return "further from the surface than the largest distance";
  }
  if (context.input.may_fly && !context.input.may_fly(position)) {
    return "in space that is not known to be free";
  }
  return "";
}

bool IsNearInAngle(const NextBestViewOptions& options, double a_rad, double b_rad) {
  // 1e-9: an angle that is the limit in degrees must not fail by rounding.
  return std::abs(NormalizeAngle(a_rad - b_rad)) <=
         DegToRad(options.max_angle_to_existing_deg) + 1e-9;
}

double UsefulRange(const SearchContext& context) {
  const double max_range_m = context.options.max_range_m;
  if (context.min_projection_ratio <= 0) return max_range_m;
  // γ = fx fy cosθ / (r² cos³α) at the angle α off the optical axis; largest in a corner.
  const PinholeCamera& camera = context.camera();
  double stretch = 0;  // 1 / cosα
  for (const double u : {0.0, static_cast<double>(camera.width)}) {
    for (const double v : {0.0, static_cast<double>(camera.height)}) {
      stretch = std::max(stretch, camera.Ray({u, v}).norm());
    }
  }
  return std::min(max_range_m, std::sqrt(camera.fx * camera.fy * stretch * stretch * stretch /
                                         context.min_projection_ratio));
}

double SunFactor(const NextBestViewOptions& options, const ViewDirection& direction) {
  if (options.sun_weight <= 0) return 1;
  const Eigen::Vector3d to_sun =
      DirectionInWorld({DegToRad(options.sun_azimuth_deg), DegToRad(options.sun_elevation_deg)});
  return 1 - options.sun_weight * 0.5 * (1 + to_sun.dot(DirectionInWorld(direction)));
}

}  // namespace colmap_ext
