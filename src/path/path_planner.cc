#include "colmap_ext/path/path_planner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "colmap_ext/path/clearance.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"
#include "path/leg_planner.h"
#include "path/tour.h"

namespace colmap_ext {
namespace {

// Clearances further than this are not told apart.
constexpr double kMaxClearance_m = 50;
constexpr double kClearanceTolerance_m = 0.02;

using Polyline = std::vector<Eigen::Vector3d>;

double Length(const Polyline& polyline) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    length += (polyline[i + 1] - polyline[i]).norm();
  }
  return length;
}

std::string Metres(double value) { return FormatNumber("%.2f m", value); }

// The volume in which detours are looked for: start and views, and room to fly around and over the
// surface between them, but at most a cell lower than the lowest of them: what cannot be gone
// around is flown over, and where the surface lacks the ground nothing dives below it.
Eigen::AlignedBox3d SearchBox(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                              const TriangleMesh& surface, const PathOptions& options) {
  Eigen::AlignedBox3d box(start);
  for (const PlannedView& view : views) {
    if (view.position.allFinite()) box.extend(view.position);
  }
  if (!surface.vertices.empty()) {
    const double over_top = BoundsOf(surface).max().z() + options.safe_distance_m;
    box.extend(Eigen::Vector3d(start.x(), start.y(), over_top));
  }
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(options.detour_margin_m + 2 * options.cell_size_m);
  const double floor_m = box.min().z() - options.cell_size_m;
  box = Eigen::AlignedBox3d(box.min() - margin, box.max() + margin);
  box.min().z() = floor_m;
  return box;
}

// All legs between the start (node 0) and the views (node i + 1).
class LegTable {
 public:
  LegTable(const LegPlanner& planner, Polyline places)
      : planner_(planner), places_(std::move(places)), legs_(places_.size() * places_.size()) {}

  const Polyline& Leg(std::size_t from, std::size_t to) const {
    return legs_[from * places_.size() + to];
  }

  // Finds the leg and its reverse.
  void Find(std::size_t from, std::size_t to) {
    Set(from, to, planner_.FindLeg(places_[from], places_[to]));
  }

  // Every view has a leg from the start. Where a direct one between two views was not found (a view
  // in a nook that only a straight leg enters), they are joined by way of the start.
  void JoinByWayOfStart(std::size_t from, std::size_t to) {
    if (!Leg(from, to).empty()) return;
    Polyline leg = Leg(from, 0);
    leg.insert(leg.end(), Leg(0, to).begin() + 1, Leg(0, to).end());
    Set(from, to, std::move(leg));
  }

 private:
  void Set(std::size_t from, std::size_t to, Polyline leg) {
    legs_[to * places_.size() + from] = Polyline(leg.rbegin(), leg.rend());
    legs_[from * places_.size() + to] = std::move(leg);
  }

  const LegPlanner& planner_;
  Polyline places_;
  std::vector<Polyline> legs_;
};

// Where planning begins: `start` itself, or, when it is a little too near to the surface, the end
// of a straight leg away from it.
Polyline LeaveStart(const LegPlanner& planner, const FreeSpace& free_space,
                    const Eigen::Vector3d& start, const PathOptions& options,
                    const JobControl& job) {
  const std::string complaint = planner.WhyNotAt(start);
  if (complaint.empty()) return {start};
  const RayScene& scene = free_space.ray_scene();
  const double clearance = scene.DistanceToSurface(start, kMaxClearance_m);
  const double least = options.safe_distance_m - options.start_tolerance_m;
  if (clearance >= least && options.safe_distance_m + options.proof_tolerance_m > clearance) {
    const double keep = std::max(0.0, clearance - 2 * options.proof_tolerance_m);
    const int rings = 2 + static_cast<int>(options.start_tolerance_m / options.cell_size_m);
    const auto away = planner.NearestFreeCenter(start, rings, [&](const Eigen::Vector3d& center) {
      return ProveClearance(scene, start, center, keep, options.proof_tolerance_m);
    });
    if (away) {
      job.Warn("path: the start is " + Metres(clearance) + " from the surface, nearer than the " +
               "safe distance; leaving it first");
      return {start, *away};
    }
  }
  throw Error("path: cannot start: " + Metres(clearance) + " from the surface (safe distance " +
              Metres(options.safe_distance_m) + "), " + complaint +
              "; move the vehicle or lower --Path.safe_distance_m");
}

// The views that may be flown to, in their order; the others go to `path`.
std::vector<PlannedView> AdmissibleViews(const LegPlanner& planner,
                                         const std::vector<PlannedView>& views,
                                         const JobControl& job, FlightPath* path) {
  std::vector<PlannedView> admissible;
  for (const PlannedView& view : views) {
    const std::string complaint = planner.WhyNotAt(view.position);
    if (complaint.empty()) {
      admissible.push_back(view);
    } else {
      job.Warn("path: view " + std::to_string(view.id) + " is dropped: " + complaint);
      path->dropped_view_ids.push_back(view.id);
    }
  }
  return admissible;
}

// Waypoints through the corners of the legs in the tour's order. A view's waypoint ends its leg.
std::vector<Waypoint> WaypointsOf(const Polyline& leave, const LegTable& legs,
                                  const std::vector<int>& tour,
                                  const std::vector<PlannedView>& views) {
  std::vector<Waypoint> waypoints;
  for (const Eigen::Vector3d& place : leave) waypoints.push_back({place, {}, -1});
  for (std::size_t k = 0; k + 1 < tour.size(); ++k) {
    const PlannedView& view = views[static_cast<std::size_t>(tour[k + 1] - 1)];
    const Polyline& leg =
        legs.Leg(static_cast<std::size_t>(tour[k]), static_cast<std::size_t>(tour[k + 1]));
    for (std::size_t i = 1; i < leg.size(); ++i) {
      waypoints.push_back({leg[i], view.direction, i + 1 == leg.size() ? view.id : -1});
    }
  }
  for (std::size_t i = 0; i < leave.size() && leave.size() < waypoints.size(); ++i) {
    waypoints[i].direction = waypoints[leave.size()].direction;
  }
  return waypoints;
}

Eigen::MatrixXd LengthsOf(const LegTable& legs, std::size_t num_nodes) {
  const auto n = static_cast<Eigen::Index>(num_nodes);
  Eigen::MatrixXd length = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i + 1; j < n; ++j) {
      length(i, j) = Length(legs.Leg(static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
      length(j, i) = length(i, j);
    }
  }
  return length;
}

Polyline PlacesOf(const Eigen::Vector3d& start, const std::vector<PlannedView>& views) {
  Polyline places = {start};
  for (const PlannedView& view : views) places.push_back(view.position);
  return places;
}

// Views with a proved leg from `start`; the others go to `path`.
std::vector<PlannedView> ReachableViews(const LegPlanner& planner, const Eigen::Vector3d& start,
                                        const std::vector<PlannedView>& views,
                                        const JobControl& job, FlightPath* path) {
  std::vector<char> is_reached(views.size(), 0);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    is_reached[i] = planner.FindLeg(start, views[i].position).empty() ? 0 : 1;
  });
  std::vector<PlannedView> reachable;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (is_reached[i] != 0) {
      reachable.push_back(views[i]);
    } else {
      job.Warn("path: view " + std::to_string(views[i].id) +
               " is dropped: no way to it can be proved");
      path->dropped_view_ids.push_back(views[i].id);
    }
  }
  return reachable;
}

void FindAllLegs(std::size_t num_nodes, const JobControl& job, LegTable* legs) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < num_nodes; ++i) {
    for (std::size_t j = i + 1; j < num_nodes; ++j) pairs.emplace_back(i, j);
  }
  tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
    if (!job.IsCancelled()) legs->Find(pairs[k].first, pairs[k].second);
  });
  job.ThrowIfCancelled();
  for (const auto& [from, to] : pairs) {
    if (from != 0) legs->JoinByWayOfStart(from, to);
  }
}

// Dropped views in the order of `views`.
void SortDropped(const std::vector<PlannedView>& views, FlightPath* path) {
  std::vector<int> sorted;
  for (const PlannedView& view : views) {
    const auto& dropped = path->dropped_view_ids;
    if (std::find(dropped.begin(), dropped.end(), view.id) != dropped.end()) {
      sorted.push_back(view.id);
    }
  }
  path->dropped_view_ids = sorted;
}

}  // namespace

std::function<bool(const Eigen::Vector3d&)> FlyablePositions(const TriangleMesh& surface,
                                                             const std::vector<PosedPhoto>& photos,
                                                             const Eigen::Vector3d& start,
                                                             const PathOptions& options) {
  ThrowIfInvalid(options.Check());
  const auto space = std::make_shared<const FreeSpace>(
      surface, photos, std::vector<Eigen::Vector3d>{start},
      FreeSpaceOptions{options.safe_distance_m, options.flown_margin_m});
  return [space, options](const Eigen::Vector3d& point) {
    if (!point.allFinite()) return false;
    if (options.max_altitude_m != 0 && point.z() > options.max_altitude_m) return false;
    const double least = options.safe_distance_m + options.proof_tolerance_m;
    if (space->ray_scene().DistanceToSurface(point, least + 1) < least) return false;
    if (options.unknown == "free") return true;
    const VoxelGrid grid(Eigen::AlignedBox3d(Eigen::Vector3d::Zero()), options.cell_size_m);
    return grid.AllOnSegment(point, point, [&](const Cell& cell) {
      return space->IsKnownFree(grid.Center(cell), grid.cell_size_m() / 2);
    });
  };
}

void RequireMetric(const WorldFrame& frame) {
  if (!frame.is_metric_enu) {
    throw Error(
        "the model is not in metres with z up (photos without GPS and no position file), so no "
        "flight can be planned from it; give positions by --pose_prior_path");
  }
}

double EstimateDuration(const std::vector<Waypoint>& waypoints, const PathOptions& options) {
  double duration_s = 0;
  double yaw_rad = waypoints.empty() ? 0 : waypoints.front().direction.yaw_rad;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (i > 0) {
      const double length = (waypoints[i].position - waypoints[i - 1].position).norm();
      duration_s += length / options.speed_m_s;
    }
    if (waypoints[i].view_id < 0) continue;
    const double turn_rad = std::abs(NormalizeAngle(waypoints[i].direction.yaw_rad - yaw_rad));
    duration_s += RadToDeg(turn_rad) / options.yaw_rate_deg_s + options.hover_s;
    yaw_rad = waypoints[i].direction.yaw_rad;
  }
  return duration_s;
}

FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  if (!start.allFinite()) throw Error("path: the start position is not finite");
  const FreeSpace free_space(surface, photos, {start},
                             {options.safe_distance_m, options.flown_margin_m});
  const LegPlanner planner(free_space, SearchBox(start, views, surface, options), options);

  FlightPath path;
  const Polyline leave = LeaveStart(planner, free_space, start, options, job);
  const std::vector<PlannedView> admissible = AdmissibleViews(planner, views, job, &path);
  const std::vector<PlannedView> reachable =
      ReachableViews(planner, leave.back(), admissible, job, &path);
  SortDropped(views, &path);
  job.ThrowIfCancelled();

  LegTable legs(planner, PlacesOf(leave.back(), reachable));
  FindAllLegs(reachable.size() + 1, job, &legs);
  const std::vector<int> tour = ShortOpenTour(LengthsOf(legs, reachable.size() + 1));
  path.waypoints = WaypointsOf(leave, legs, tour, reachable);

  Polyline polyline;
  for (const Waypoint& waypoint : path.waypoints) polyline.push_back(waypoint.position);
  path.length_m = Length(polyline);
  path.duration_s = EstimateDuration(path.waypoints, options);
  path.min_clearance_m =
      ProvedMinClearance(free_space.ray_scene(), polyline, kClearanceTolerance_m, kMaxClearance_m);
  return path;
}

}  // namespace colmap_ext
