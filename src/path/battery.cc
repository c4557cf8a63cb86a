#include "path/battery.h"

#include <limits>

namespace colmap_ext {

BatterySplit SplitByBattery(const std::vector<int>& tour, int home, double usable_s,
                            const std::function<double(int, int)>& seconds) {
  BatterySplit split;
  std::vector<int> flight = {tour.front()};
  double used_s = 0;
  for (std::size_t i = 1; i < tour.size(); ++i) {
    const int view = tour[i];
    const double back_s = seconds(view, home);
    const double onwards_s = used_s + seconds(flight.back(), view);
    if (onwards_s + back_s <= usable_s) {
      flight.push_back(view);
      used_s = onwards_s;
      continue;
    }
    const double afresh_s = seconds(home, view);
    if (afresh_s + back_s > usable_s) {
      split.too_far.push_back(view);
      continue;
    }
    split.flights.push_back(flight);
    flight = {home, view};
    used_s = afresh_s;
  }
  split.flights.push_back(flight);
  return split;
}

double UsableSeconds(const PathOptions& options) {
  if (options.battery_s <= 0) return std::numeric_limits<double>::infinity();
  return options.battery_s * (1 - options.battery_reserve) - options.takeoff_landing_s;
}

double BatteryShare(double flight_s, const PathOptions& options) {
  return options.battery_s > 0 ? (flight_s + options.takeoff_landing_s) / options.battery_s : 0;
}

}  // namespace colmap_ext
