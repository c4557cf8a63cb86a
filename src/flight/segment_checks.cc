#include "colmap_ext/flight/segment_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colmap_ext/geom/polygon.h"
#include "colmap_ext/path/clearance.h"

namespace colmap_ext {
namespace {

constexpr double kTolerance = 0.05;  // m, of the proof
constexpr double kBorder = 1e-9;     // m

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Whether the open segments a-b and c-d cross in one point inside of both.
bool Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
           const Eigen::Vector2d& d) {
  const double side_c = Cross(b - a, c - a);
  const double side_d = Cross(b - a, d - a);
  const double side_a = Cross(d - c, a - c);
  const double side_b = Cross(d - c, b - c);
  return side_c * side_d < 0 && side_a * side_b < 0;
}

std::string CheckFence(const MissionLimits& limits, const Eigen::Vector2d& from,
                       const Eigen::Vector2d& to) {
  const std::vector<Eigen::Vector2d>& fence = limits.fence;
  if (fence.empty()) return "";
  if (!IsInsidePolygon(fence, to)) return "the target is outside of the fence";
  if (!IsInsidePolygon(fence, from)) return "";  // coming back
  for (std::size_t i = 0; i < fence.size(); ++i) {
    if (Cross(from, to, fence[i], fence[(i + 1) % fence.size()])) {
      return "the way leaves the fence";
    }
  }
  return "";
}

// A start outside of the limits may be left, by the shortest piece of the way that leads out.
std::string CheckSite(const FlightLimits& site, const Eigen::Vector3d& from,
                      const Eigen::Vector3d& to) {
  if (site.IsEmpty()) return "";
  constexpr double kStepM = 0.5;
  const std::string why = site.WhyNot(to);
  if (!why.empty()) return "the target is " + why;
  const double length = (to - from).norm();
  double left = 0;
  const auto place = [&] { return left < length ? from + left / length * (to - from) : to; };
  while (left < length && !site.Allows(place())) left += kStepM;
  return site.AllowsSegment(place(), to, 0) ? "" : "the way leaves the flight limits of the site";
}

std::string CheckHeights(const FlightSpace& space, const Eigen::Vector3d& to) {
  const double height_m = to.z() - space.home.z();
  char text[160];
  if (height_m < space.limits.min_relative_height_m) {
    std::snprintf(text, sizeof text, "%.1f m above home is below the least height of %.1f m",
                  height_m, space.limits.min_relative_height_m);
    return text;
  }
  if (height_m > space.limits.max_relative_height_m) {
    std::snprintf(text, sizeof text, "%.1f m above home is above the greatest height of %.1f m",
                  height_m, space.limits.max_relative_height_m);
    return text;
  }
  const double distance_m = (to - space.home).head<2>().norm();
  if (distance_m > space.limits.max_distance_m) {
    std::snprintf(text, sizeof text, "%.0f m from home is beyond the greatest distance of %.0f m",
                  distance_m, space.limits.max_distance_m);
    return text;
  }
  return "";
}

std::string CheckClearance(const FlightSpace& space, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& to) {
  if (space.surface == nullptr) return "";
  const double wanted_m = std::max(0.0, space.safe_distance_m - space.slack_m);
  const double here_m = space.surface->DistanceToSurface(from, wanted_m + 1);
  // From a place that is nearer than that, the way may lead away, but not nearer.
  const double required_m = std::max(0.0, std::min(wanted_m, here_m - 2 * kTolerance));
  const double there_m = space.surface->DistanceToSurface(to, wanted_m + 1);
  const bool is_clear = there_m >= std::max(0.0, wanted_m - kTolerance) &&
                        ProveClearance(*space.surface, from, to, required_m, kTolerance);
  if (is_clear) return "";
  char text[160];
  std::snprintf(text, sizeof text,
                "the way is not proved to stay %.2f m from the surface (start %.2f m, target "
                "%.2f m)",
                wanted_m, here_m, there_m);
  return text;
}

}  // namespace

bool IsInsidePolygon(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point) {
  return IsInsideRing(polygon, point) || DistanceToBorder(polygon, point) < kBorder;
}

std::string CheckSegment(const FlightSpace& space, const Eigen::Vector3d& from,
                         const Eigen::Vector3d& to) {
  if (!from.allFinite() || !to.allFinite()) return "a position is not a finite number";
  std::string complaint = CheckFence(space.limits, from.head<2>(), to.head<2>());
  if (complaint.empty()) complaint = CheckSite(space.limits.site, from, to);
  if (complaint.empty()) complaint = CheckHeights(space, to);
  if (complaint.empty()) complaint = CheckClearance(space, from, to);
  return complaint;
}

std::vector<Eigen::Vector3d> PlanLegs(const FlightSpace& space, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to, std::optional<double> transit_z_m,
                                      bool must_detour, std::string* complaint) {
  if (!must_detour) {
    *complaint = CheckSegment(space, from, to);
    if (complaint->empty()) return {to};
  } else if (!transit_z_m) {
    *complaint = "nothing is known about the way there, and the mission has no transit_z_m";
  }
  if (!transit_z_m) return {};
  const double top_z_m = std::max({*transit_z_m, from.z(), to.z()});
  std::vector<Eigen::Vector3d> legs = {
      {from.x(), from.y(), top_z_m}, {to.x(), to.y(), top_z_m}, to};
  Eigen::Vector3d start = from;
  for (const Eigen::Vector3d& leg : legs) {
    const std::string detour_complaint = CheckSegment(space, start, leg);
    if (!detour_complaint.empty()) {
      *complaint += (complaint->empty() ? "" : "; ") + ("at transit height: " + detour_complaint);
      return {};
    }
    start = leg;
  }
  complaint->clear();
  return legs;
}

double BatteryNeeded(const EnergyNeed& need, double speed_m_s, double percent_per_minute) {
  // Descents are slower than flight: 1 m/s is what both stacks do near the ground.
  const double seconds =
      (need.way_m + need.return_m) / speed_m_s + need.hover_s + std::max(0.0, need.height_m);
  return seconds / 60 * percent_per_minute;
}

}  // namespace colmap_ext
