#include "colmap_ext/path/segment_check.h"

#include <algorithm>

#include "colmap_ext/path/clearance.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

constexpr double kShortestPiece_m = 0.05;

bool IsTooHigh(const SegmentRules& rules, double z) {
  return rules.max_altitude_m != 0 && z + rules.position_error_m > rules.max_altitude_m;
}

}  // namespace

bool IsSegmentKnown(const FreeSpace& space, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double radius_m) {
  const Eigen::Vector3d middle = (a + b) / 2;
  const double half_length = (b - a).norm() / 2;
  if (space.IsKnownFree(middle, radius_m + half_length)) return true;
  if (2 * half_length <= kShortestPiece_m || !space.IsKnownFree(middle, radius_m)) return false;
  return IsSegmentKnown(space, a, middle, radius_m) && IsSegmentKnown(space, middle, b, radius_m);
}

std::string WhyNotHover(const FreeSpace& space, const SegmentRules& rules,
                        const Eigen::Vector3d& point) {
  if (!point.allFinite()) return "its position is not finite";
  if (IsTooHigh(rules, point.z())) return "it is above the ceiling";
  if (!rules.limits.Allows(point, rules.position_error_m)) {
    const std::string why = rules.limits.WhyNot(point);
    return why.empty() ? "it is nearer to a flight limit than the position error" : "it is " + why;
  }
  const double least = rules.ClearanceOfLine() + rules.proof_tolerance_m;
  const double distance = space.ray_scene().DistanceToSurface(point, least + 1);
  if (distance < least) {
    return "it is " + FormatNumber("%.2f m", distance) +
           " from the surface, nearer than the safe " + "distance and position error of " +
           FormatNumber("%.2f m", least);
  }
  if (!rules.unknown_is_free && !space.IsKnownFree(point, rules.position_error_m)) {
    return "it is in unknown space";
  }
  return "";
}

std::string WhyNotFly(const FreeSpace& space, const SegmentRules& rules, const Eigen::Vector3d& a,
                      const Eigen::Vector3d& b) {
  if (!a.allFinite() || !b.allFinite()) return "it has an end that is not finite";
  if (IsTooHigh(rules, std::max(a.z(), b.z()))) return "it leads above the ceiling";
  if (!rules.limits.AllowsSegment(a, b, rules.position_error_m)) {
    return "it leads out of the flight limits";
  }
  if (!ProveClearance(space.ray_scene(), a, b, rules.ClearanceOfLine(), rules.proof_tolerance_m)) {
    return "it leads too near to the surface";
  }
  if (!rules.unknown_is_free && !IsSegmentKnown(space, a, b, rules.position_error_m)) {
    return "it leads through unknown space";
  }
  return "";
}

}  // namespace colmap_ext
