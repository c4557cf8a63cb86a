#pragma once

#include <functional>
#include <vector>

#include "colmap_ext/path/path_planner.h"

namespace colmap_ext {

struct BatterySplit {
  // Nodes in the order of flight. The first begins with the tour's first node, the others with
  // `home`, which also follows each of them (not written out). The first may hold its start alone:
  // then it flies home at once.
  std::vector<std::vector<int>> flights;
  std::vector<int> too_far;  // further than a full battery carries there and back
};

// Cuts the tour so that each flight and its way home take at most `usable_s`. `seconds(i, j)`: what
// it takes from i to j, the stop at j included. The tour is not empty; its first node is where the
// vehicle is (with a full battery). The last flight need not be flown home, but could be.
BatterySplit SplitByBattery(const std::vector<int>& tour, int home, double usable_s,
                            const std::function<double(int, int)>& seconds);

// What a battery flies between take-off and landing, the reserve kept; infinite without a limit.
double UsableSeconds(const PathOptions& options);

// Part of a full battery that a flight of so many seconds takes, take-off and landing included; 0
// without a limit.
double BatteryShare(double flight_s, const PathOptions& options);

}  // namespace colmap_ext
