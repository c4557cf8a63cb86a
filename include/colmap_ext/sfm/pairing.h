// Which photos are worth matching (paper, Sec. "Sparse Reconstruction": only nearby ones).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct PairingOptions {
  // Photos nearer than this are matched; metres, > 0. The paper's 2 m suits a room; a flight around
  // a building takes a photo every 2 or 3 m, and 12 m joins about five on either side.
  double max_distance_m = 12;
  // A photo is matched with at least so many nearest ones, however far; >= 1.
  int min_neighbors = 12;
  // ... and with at most so many nearest ones inside the radius, so that the work stays linear in
  // the number of photos where a drone took many in one place; >= min_neighbors.
  int max_neighbors = 20;
  // Photos whose optical axes differ by more are not matched when both are known; degrees, (0,
  // 180].
  double max_axis_angle_deg = 75;
  // Photos without position: matched with all others up to so many photos; >= 2.
  int exhaustive_limit = 80;
  // ... and beyond it with so many next ones in name order, and those 2^k further; >= 1.
  int sequential_overlap = 10;

  std::string Check() const;  // "" when all is well
};
void BindOptions(OptionSet& set, PairingOptions* options);  // section "Pairing"

// What is known about a photo before it is matched.
struct PhotoPlace {
  std::optional<Eigen::Vector3d> position_m;    // any one metric frame
  std::optional<Eigen::Vector3d> optical_axis;  // unit, same frame
};

// Two indices into the photos, first < second.
using PhotoPair = std::pair<int, int>;

// Pairs to match, sorted, each once. `places` are in the photos' name order. At least one photo of
// a pair is new (`is_new`, same size as `places`), and no pair is in `existing`. Throws UsageError
// for invalid options.
std::vector<PhotoPair> ChoosePairs(const std::vector<PhotoPlace>& places,
                                   const std::vector<bool>& is_new,
                                   const std::set<PhotoPair>& existing,
                                   const PairingOptions& options);

}  // namespace colmap_ext
