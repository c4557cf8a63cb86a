#include "colmap_ext/path/path_planner.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/path/clearance.h"
#include "colmap_ext/path/flight_time.h"
#include "colmap_ext/scene/image_list.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"
#include "path/battery.h"
#include "path/leave_start.h"
#include "path/leg_table.h"
#include "path/tour.h"

namespace colmap_ext {
namespace {

constexpr double kClearanceTolerance_m = 0.02;

// The volume in which detours are looked for: start, home and views, and room to fly around and
// over the surface between them, but at most a cell lower than the lowest of them: what cannot be
// gone around is flown over, and where the surface lacks the ground nothing dives below it.
Eigen::AlignedBox3d SearchBox(const std::vector<Eigen::Vector3d>& stays,
                              const std::vector<PlannedView>& views, const FreeSpace& space,
                              const PathOptions& options) {
  Eigen::AlignedBox3d box(stays.front());
  for (const Eigen::Vector3d& stay : stays) box.extend(stay);
  for (const PlannedView& view : views) {
    if (view.position.allFinite()) box.extend(view.position);
  }
  if (std::isfinite(space.SurfaceTop())) {
    const double over_top = space.SurfaceTop() + options.safe_distance_m + options.position_error_m;
    box.extend(Eigen::Vector3d(stays.front().x(), stays.front().y(), over_top));
  }
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(options.detour_margin_m + 2 * options.cell_size_m);
  const double floor_m = box.min().z() - options.cell_size_m;
  box = Eigen::AlignedBox3d(box.min() - margin, box.max() + margin);
  box.min().z() = floor_m;
  return box;
}

class Planner {
 public:
  Planner(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
          const FreeSpace& space, const PathOptions& options, const JobControl& job)
      : views_(views),
        options_(options),
        job_(job),
        home_(options.home.empty() ? start : ParsePlace(options.home)),
        legs_(space, RulesOf(options), SearchBox({start, home_}, views, space, options),
              options.cell_size_m),
        reasons_(views.size()),
        leave_(LeaveStart(legs_, start, options, job)) {}

  FlightPath Plan() {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      Drop(i, WhyNotHover(legs_.free_space(), legs_.rules(), views_[i].position));
    }
    LegTable table(legs_, Places(), job_);
    if (!options_.home.empty() && !table.IsReached(1)) {
      throw Error("path: no proved way from the start to --Path.home " + options_.home +
                  WhyNotHome());
    }
    DropUnreached(table);
    table.FindAll(job_);
    const std::vector<std::vector<int>> flights = SplitTour(table);
    FlightPath path;
    for (const Eigen::Vector3d& place : leave_) path.waypoints.push_back({place, {}, -1});
    for (std::size_t i = 0; i < flights.size(); ++i) {
      AddFlight(table, flights[i], i + 1 == flights.size(), &path);
    }
    Finish(&path);
    return path;
  }

 private:
  // Nodes of the table: the start, home when it is another place, then the views that remain.
  int HomeNode() const { return options_.home.empty() ? 0 : 1; }
  std::size_t FirstViewNode() const { return static_cast<std::size_t>(HomeNode()) + 1; }
  const PlannedView& ViewOf(int node) const {
    return views_[remaining_[static_cast<std::size_t>(node) - FirstViewNode()]];
  }

  void Drop(std::size_t view, const std::string& reason) {
    if (reason.empty() || !reasons_[view].empty()) return;
    reasons_[view] = reason;
    job_.Warn("path: view " + std::to_string(views_[view].id) + " is dropped: " + reason);
  }

  std::string WhyNotHome() const {
    const std::string complaint = WhyNotHover(legs_.free_space(), legs_.rules(), home_);
    return complaint.empty() ? "" : ": " + complaint;
  }

  Polyline Places() {
    Polyline places = {leave_.back()};
    if (!options_.home.empty()) places.push_back(home_);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!reasons_[i].empty()) continue;
      remaining_.push_back(i);
      places.push_back(views_[i].position);
    }
    return places;
  }

  void DropUnreached(const LegTable& table) {
    std::vector<std::size_t> reached;
    for (std::size_t i = 0; i < remaining_.size(); ++i) {
      if (table.IsReached(FirstViewNode() + i)) {
        reached.push_back(remaining_[i]);
      } else {
        const std::string straight = WhyNotFly(legs_.free_space(), legs_.rules(), leave_.back(),
                                               views_[remaining_[i]].position);
        Drop(remaining_[i], "no way to it can be proved (straight there " + straight +
                                ", and no detour was found)");
      }
    }
    remaining_ = std::move(reached);
  }

  // From hover at one node to the end of the photo at the other.
  double Seconds(const LegTable& table, int from, int to) const {
    const Polyline leg = table.Leg(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
    double seconds = 0;
    for (std::size_t i = 0; i + 1 < leg.size(); ++i) {
      seconds += TimeBetween(leg[i], leg[i + 1], options_);
    }
    if (to <= HomeNode()) return seconds;
    // Where the turn starts from is known; a flight that comes from home turns by at most half.
    double turn_rad = DegToRad(180);
    if (from > HomeNode()) {
      turn_rad =
          std::abs(NormalizeAngle(ViewOf(to).direction.yaw_rad - ViewOf(from).direction.yaw_rad));
    }
    return seconds + options_.hover_s + RadToDeg(turn_rad) / options_.yaw_rate_deg_s;
  }

  std::vector<std::vector<int>> SplitTour(const LegTable& table) {
    std::vector<int> tour = TourOf(table);
    BatterySplit split = SplitByBattery(tour, HomeNode(), UsableSeconds(options_),
                                        [&](int from, int to) { return Seconds(table, from, to); });
    for (const int node : split.too_far) {
      Drop(remaining_[static_cast<std::size_t>(node) - FirstViewNode()],
           "it is further than one battery carries there and back");
    }
    return split.flights;
  }

  // Home is no stop of the tour.
  std::vector<int> TourOf(const LegTable& table) const {
    std::vector<int> nodes = {0};
    for (std::size_t i = 0; i < remaining_.size(); ++i) {
      nodes.push_back(static_cast<int>(FirstViewNode() + i));
    }
    std::vector<int> tour = ShortOpenTour(table.lengths()(nodes, nodes));
    for (int& node : tour) node = nodes[static_cast<std::size_t>(node)];
    return tour;
  }

  void AddLeg(const LegTable& table, int from, int to, FlightPath* path) const {
    const Polyline leg = table.Leg(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
    const bool is_view = to > HomeNode();
    const ViewDirection direction =
        is_view ? ViewOf(to).direction : path->waypoints.back().direction;
    for (std::size_t i = 1; i < leg.size(); ++i) {
      const bool is_end = i + 1 == leg.size();
      path->waypoints.push_back({leg[i], direction, is_view && is_end ? ViewOf(to).id : -1});
    }
  }

  void AddFlight(const LegTable& table, const std::vector<int>& nodes, bool is_last,
                 FlightPath* path) const {
    BatteryFlight flight;
    flight.first_waypoint = path->flights.empty() ? 0 : path->waypoints.size() - 1;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      AddLeg(table, nodes[i], nodes[i + 1], path);
    }
    if (path->flights.empty() && path->waypoints.size() > leave_.size()) {
      for (std::size_t i = 0; i < leave_.size(); ++i) {
        path->waypoints[i].direction = path->waypoints[leave_.size()].direction;
      }
    }
    flight.return_s = Seconds(table, nodes.back(), HomeNode());
    const bool returns = !is_last || options_.return_home;
    if (returns) AddLeg(table, nodes.back(), HomeNode(), path);
    flight.last_waypoint = path->waypoints.size() - 1;
    const std::vector<Waypoint> part(
        path->waypoints.begin() + static_cast<std::ptrdiff_t>(flight.first_waypoint),
        path->waypoints.end());
    for (std::size_t i = 0; i + 1 < part.size(); ++i) {
      flight.length_m += (part[i + 1].position - part[i].position).norm();
    }
    flight.duration_s = EstimateDuration(part, options_);
    flight.battery_share =
        BatteryShare(flight.duration_s + (returns ? 0 : flight.return_s), options_);
    path->flights.push_back(flight);
  }

  void Finish(FlightPath* path) const {
    Polyline polyline;
    for (const Waypoint& waypoint : path->waypoints) polyline.push_back(waypoint.position);
    path->length_m = LengthOf(polyline);
    for (const BatteryFlight& flight : path->flights) path->duration_s += flight.duration_s;
    const double of_line = ProvedMinClearance(legs_.free_space().ray_scene(), polyline,
                                              kClearanceTolerance_m, kMaxClearance_m);
    path->min_clearance_m = std::max(0.0, of_line - options_.position_error_m);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (reasons_[i].empty()) continue;
      path->dropped_view_ids.push_back(views_[i].id);
      path->drop_reasons.push_back(reasons_[i]);
    }
  }

  const std::vector<PlannedView>& views_;
  const PathOptions& options_;
  const JobControl& job_;
  Eigen::Vector3d home_;
  LegPlanner legs_;
  std::vector<std::string> reasons_;    // why a view is dropped; one a view
  Polyline leave_;                      // from where the vehicle is to where rules hold
  std::vector<std::size_t> remaining_;  // views that are not dropped, in their order
};

}  // namespace

void RequireMetric(const WorldFrame& frame) {
  if (!frame.is_metric_enu) {
    throw Error(
        "the model is not in metres with z up (photos without GPS and no position file), so no "
        "flight can be planned from it; give positions by --pose_prior_path");
  }
}

SegmentRules RulesOf(const PathOptions& options) {
  SegmentRules rules;
  rules.safe_distance_m = options.safe_distance_m;
  rules.position_error_m = options.position_error_m;
  rules.proof_tolerance_m = options.proof_tolerance_m;
  rules.max_altitude_m = options.max_altitude_m;
  rules.limits = options.limits;
  rules.unknown_is_free = options.unknown == "free";
  return rules;
}

void ReadZones(const WorldFrame& frame, PathOptions* options) {
  if (!options->limits_path.empty()) {
    options->limits = ReadFlightLimits(options->limits_path, frame);
  }
  FreeSpaceOptions unused;
  for (const std::filesystem::path& file : SetFreeVolume(options->free_volume, &unused)) {
    const FlightLimits volumes = ReadFlightLimits(file, frame);
    options->free_zones.insert(options->free_zones.end(), volumes.zones.begin(),
                               volumes.zones.end());
  }
}

void ReadVouchedPhotos(const std::filesystem::path& workspace, PathOptions* options) {
  if (!options->vouched_image_list_path.empty()) {
    options->vouched_photos = ReadImageList(options->vouched_image_list_path);
  } else if (!workspace.empty() && !options->vouch_planned_flights) {
    options->vouched_photos = FirstFlightPhotos(Workspace(workspace));
  }
}

FreeSpace KnownSpace(const Surface& surface, const std::vector<PosedPhoto>& photos,
                     const Eigen::Vector3d& start, const PathOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!start.allFinite()) throw Error("path: the start position is not finite");
  FreeSpaceOptions known;
  known.above_top_m = options.safe_distance_m;
  known.flown_margin_m = options.flown_margin_m;
  known.confident_spacing_m = options.confident_spacing_m;
  SetFreeVolume(options.free_volume, &known);
  known.zones.insert(known.zones.end(), options.free_zones.begin(), options.free_zones.end());
  // The vehicle is off by position_error_m at most, and from there so again.
  known.visited_margin_m = 2 * options.position_error_m;
  if (options.unknown == "free") return {surface, {}, {}, known};  // nobody will ask
  FlownPlaces flown{{}, {start}};
  for (const PosedPhoto& photo : photos) {
    const bool is_vouched = !options.vouched_photos || options.vouched_photos->contains(photo.name);
    (is_vouched ? flown.vouched : flown.visited).push_back(CameraCenter(photo.cam_from_world));
  }
  return {surface, photos, flown, known};
}

std::function<bool(const Eigen::Vector3d&)> FlyablePositions(std::shared_ptr<const FreeSpace> space,
                                                             const PathOptions& options) {
  ThrowIfInvalid(options.Check());
  return [space = std::move(space), rules = RulesOf(options)](const Eigen::Vector3d& point) {
    return WhyNotHover(*space, rules, point).empty();
  };
}

std::function<bool(const Eigen::Vector3d&)> FlyablePositions(const TriangleMesh& surface,
                                                             const std::vector<PosedPhoto>& photos,
                                                             const Eigen::Vector3d& start,
                                                             const PathOptions& options) {
  return FlyablePositions(
      std::make_shared<const FreeSpace>(KnownSpace({surface}, photos, start, options)), options);
}

FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const FreeSpace& space, const PathOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  if (!start.allFinite()) throw Error("path: the start position is not finite");
  return Planner(start, views, space, options, job).Plan();
}

FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const Surface& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  return PlanPath(start, views, KnownSpace(surface, photos, start, options), options, job);
}

FlightPath PlanPath(const Eigen::Vector3d& start, const std::vector<PlannedView>& views,
                    const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
                    const PathOptions& options, const JobControl& job) {
  return PlanPath(start, views, Surface{surface, {}, {}, {}}, photos, options, job);
}

}  // namespace colmap_ext
