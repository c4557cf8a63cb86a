#include <cmath>

#include "colmap_ext/path/flight_time.h"
#include "colmap_ext/util/error.h"
#include "path/battery.h"

namespace colmap_ext {
namespace {

// Nodes: 0 home, i + 1 view i.
class OrderedFlight {
 public:
  OrderedFlight(const std::vector<PlannedView>& views, const PathOptions& options)
      : views_(views),
        options_(options),
        home_(options.home.empty() ? views.front().position : ParsePlace(options.home)) {}

  FlightPath Fly() const {
    std::vector<int> order = {0};
    for (std::size_t i = 0; i < views_.size(); ++i) order.push_back(static_cast<int>(i) + 1);
    const BatterySplit split = SplitByBattery(order, 0, UsableSeconds(options_),
                                              [&](int from, int to) { return Seconds(from, to); });
    FlightPath path;
    for (std::size_t i = 0; i < split.flights.size(); ++i) {
      AddFlight(split.flights[i], i + 1 == split.flights.size(), &path);
    }
    for (const int node : split.too_far) {
      path.dropped_view_ids.push_back(views_[static_cast<std::size_t>(node) - 1].id);
      path.drop_reasons.push_back("it is further than one battery carries there and back");
    }
    return path;
  }

 private:
  Waypoint At(int node) const {
    if (node == 0) return {home_, {}, -1};
    const PlannedView& view = views_[static_cast<std::size_t>(node) - 1];
    return {view.position, view.direction, view.id};
  }

  double Seconds(int from, int to) const {
    Waypoint begin = At(from);
    begin.view_id = -1;  // its photo is taken
    return EstimateDuration({begin, At(to)}, options_);
  }

  void AddFlight(const std::vector<int>& nodes, bool is_last, FlightPath* path) const {
    std::vector<Waypoint> part;
    for (const int node : nodes) part.push_back(At(node));
    if (nodes.front() == 0 && part.size() > 1) part[0].direction = part[1].direction;
    BatteryFlight flight;
    flight.return_s = TimeBetween(part.back().position, home_, options_);
    const bool returns = !is_last || options_.return_home;
    if (returns) part.push_back({home_, part.back().direction, -1});
    for (std::size_t i = 0; i + 1 < part.size(); ++i) {
      flight.length_m += (part[i + 1].position - part[i].position).norm();
    }
    flight.duration_s = EstimateDuration(part, options_);
    flight.battery_share =
        BatteryShare(flight.duration_s + (returns ? 0 : flight.return_s), options_);
    // A flight begins where the one before has ended.
    const std::size_t shared = path->waypoints.empty() ? 0 : 1;
    flight.first_waypoint = path->waypoints.size() - shared;
    path->waypoints.insert(path->waypoints.end(),
                           part.begin() + static_cast<std::ptrdiff_t>(shared), part.end());
    flight.last_waypoint = path->waypoints.size() - 1;
    path->length_m += flight.length_m;
    path->duration_s += flight.duration_s;
    path->flights.push_back(flight);
  }

  const std::vector<PlannedView>& views_;
  const PathOptions& options_;
  Eigen::Vector3d home_;
};

}  // namespace

FlightPath FlyInOrder(const std::vector<PlannedView>& views, const PathOptions& options) {
  ThrowIfInvalid(options.Check());
  if (views.empty()) return {};
  return OrderedFlight(views, options).Fly();
}

}  // namespace colmap_ext
