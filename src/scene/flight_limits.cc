#include "colmap_ext/scene/flight_limits.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Signed distance to the rings in the plane, positive inside; infinite without rings.
double PlanarDepth(const std::vector<PolygonRing>& rings, const Eigen::Vector2d& point) {
  if (rings.empty()) return kInfinity;
  double distance = kInfinity;
  for (const PolygonRing& ring : rings) {
    distance = std::min(distance, DistanceToBorder(ring, point));
  }
  return IsInsideRings(rings, point) ? distance : -distance;
}

std::string Quoted(const std::string& name) { return name.empty() ? "" : " '" + name + "'"; }

}  // namespace

bool FlightZone::Contains(const Eigen::Vector3d& point) const { return Depth(point) > 0; }

double FlightZone::Depth(const Eigen::Vector3d& point) const {
  return std::min({PlanarDepth(rings, point.head<2>()), point.z() - min_z_m, max_z_m - point.z()});
}

bool FlightLimits::IsEmpty() const {
  return zones.empty() && min_z_m == -kInfinity && max_z_m == kInfinity;
}

double FlightLimits::Margin(const Eigen::Vector3d& point) const {
  if (!point.allFinite()) return -kInfinity;
  double margin = std::min(point.z() - min_z_m, max_z_m - point.z());
  double fence = -kInfinity;  // a ball inside one inclusion is inside their union
  bool has_fence = false;
  for (const FlightZone& zone : zones) {
    const double depth = zone.Depth(point);
    if (zone.kind == FlightZone::Kind::kExclusion) {
      margin = std::min(margin, -depth);
    } else {
      has_fence = true;
      fence = std::max(fence, depth);
    }
  }
  return has_fence ? std::min(margin, fence) : margin;
}

bool FlightLimits::AllowsSegment(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                 double margin_m, double tolerance_m) const {
  const double length = (to - from).norm();
  double done = 0;
  for (;;) {
    const double spare = Margin(length > 0 ? from + done / length * (to - from) : from) - margin_m;
    if (!(spare > 0)) return false;
    if (done + spare >= length) return Allows(to, margin_m);
    if (spare < tolerance_m) return false;
    done += spare;
  }
}

std::string FlightLimits::WhyNot(const Eigen::Vector3d& point) const {
  if (!(point.z() > min_z_m)) return "below the lowest altitude";
  if (!(point.z() < max_z_m)) return "above the highest altitude";
  bool has_fence = false;
  bool is_fenced = false;
  for (const FlightZone& zone : zones) {
    const double depth = zone.Depth(point);
    if (zone.kind == FlightZone::Kind::kInclusion) {
      has_fence = true;
      is_fenced = is_fenced || depth > 0;
    } else if (!(depth < 0)) {
      return "inside the no-fly zone" + Quoted(zone.name);
    }
  }
  return has_fence && !is_fenced ? "outside the geofence" : "";
}

}  // namespace colmap_ext
