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
  // "overlap": those photos that should show most of the same surface, by position, heading, field
  // of view and what is known of the surface; photos whose heading is unknown as for "radius".
  // "radius" (the paper's): those taken nearby.
  std::string strategy = "overlap";
  // Strategy "overlap": part of a photo that the other one has to show under a like angle; (0, 1).
  double min_overlap = 0.2;
  // Strategy "radius": photos nearer than this are matched; metres, > 0. The paper's 2 m suits a
  // room; a flight around a building takes a photo every 2 or 3 m, and 12 m joins about five on
  // either side.
  double max_distance_m = 12;
  // A photo is matched with at least so many best or nearest ones; >= 1. With "overlap", those
  // that cannot show anything of it are left out all the same.
  int min_neighbors = 12;
  // ... and with at most so many, so that the work stays linear in the number of photos where a
  // drone took many in one place; >= min_neighbors. Where the model tells what a new photo shows,
  // the best min_neighbors do.
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
  // Half of the picture's width and height at distance 1; the image's x axis is taken as level.
  double half_width = 0.6, half_height = 0.45;
  // Some points of the surface that it shows, where that is known; else the distance is guessed.
  std::vector<Eigen::Vector3d> seen_points;  // same frame
};

// How much two photos show of the same surface, 0 ... 1: the mean of the parts of their surface
// samples that the other one shows, each weighted by how alike both see it (full within 25 degrees
// and 1.5 times the distance, none beyond 60 degrees or 3 times). Samples are the seen points, else
// a grid at `distance_m` from the camera. Both must have position and axis.
double ExpectedOverlap(const PhotoPlace& a, double a_distance_m, const PhotoPlace& b,
                       double b_distance_m);

// Distance from each photo to what it shows, along its axis: of its seen points (median), else to
// the point that all axes pass nearest, else, where they are parallel, four times as far as the
// photos are apart (neighbours that share three quarters). 0 where position or axis is unknown.
std::vector<double> GuessSceneDistances(const std::vector<PhotoPlace>& places);

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
