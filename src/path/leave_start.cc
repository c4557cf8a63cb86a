#include "path/leave_start.h"

#include <algorithm>
#include <optional>

#include "colmap_ext/path/clearance.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

std::string Metres(double value) { return FormatNumber("%.2f m", value); }

// The free cell nearest to a start from which no proved leg leads anywhere: the vehicle is further
// from where it was sent than it should be. What is around its place is not known, but it is there,
// and may go back as far as it can be off; from there on the leg is known.
std::optional<Eigen::Vector3d> BackToKnownSpace(const LegPlanner& planner,
                                                const Eigen::Vector3d& start,
                                                const PathOptions& options) {
  const double off_m = 2 * options.position_error_m + options.start_tolerance_m;
  const int rings = 2 + static_cast<int>(off_m / options.cell_size_m);
  SegmentRules rules = planner.rules();
  rules.unknown_is_free = true;
  return planner.NearestFreeCenter(start, rings, [&](const Eigen::Vector3d& center) {
    const double part = std::min(1.0, off_m / std::max(off_m, (center - start).norm()));
    const Eigen::Vector3d known_from = start + part * (center - start);
    return WhyNotFly(planner.free_space(), rules, start, center).empty() &&
           IsSegmentKnown(planner.free_space(), known_from, center, rules.position_error_m);
  });
}

}  // namespace

Polyline LeaveStart(const LegPlanner& planner, const Eigen::Vector3d& start,
                    const PathOptions& options, const JobControl& job) {
  const SegmentRules& rules = planner.rules();
  if (planner.free_space().IsInsideSurface(start)) {
    throw Error("path: cannot start from where the vehicle is: it is inside of the model");
  }
  const std::string complaint = WhyNotHover(planner.free_space(), rules, start);
  if (complaint.empty()) {
    const auto is_proved = [&](const Eigen::Vector3d& center) {
      return planner.IsSegmentProved(start, center);
    };
    if (rules.unknown_is_free || planner.NearestFreeCenter(start, 1, is_proved)) return {start};
    const auto back = BackToKnownSpace(planner, start, options);
    if (!back) return {start};
    job.Warn("path: the start is off what is known to be free; leaving it first");
    return {start, *back};
  }
  const RayScene& scene = planner.free_space().ray_scene();
  const double clearance = scene.DistanceToSurface(start, kMaxClearance_m);
  const double least = rules.ClearanceOfLine() - options.start_tolerance_m;
  if (clearance >= least && rules.ClearanceOfLine() + rules.proof_tolerance_m > clearance) {
    const double keep = std::max(0.0, clearance - 2 * options.proof_tolerance_m);
    const int rings = 2 + static_cast<int>(options.start_tolerance_m / options.cell_size_m);
    const auto away = planner.NearestFreeCenter(start, rings, [&](const Eigen::Vector3d& center) {
      return ProveClearance(scene, start, center, keep, options.proof_tolerance_m) &&
             (rules.unknown_is_free || IsSegmentKnown(planner.free_space(), start, center, 0));
    });
    if (away) {
      job.Warn("path: the start is " + Metres(clearance) + " from the surface, nearer than the " +
               "safe distance; leaving it first");
      return {start, *away};
    }
  }
  throw Error("path: cannot start from where the vehicle is: " + complaint +
              "; move the vehicle or change --Path.safe_distance_m, --Path.free_volume or limits");
}

}  // namespace colmap_ext
