// What the map says of each iso-point, and what the dense model made of the truth there.
#pragma once

#include <vector>

#include "colmap_ext/coverage/coverage.h"
#include "support/flown_site.h"

namespace colmap_ext {

// The points of the fast model's cloud around an iso-point: what rules for laser scanners look at.
struct CloudAround {
  double spacing_m = 0;   // 1 / sqrt(points an area)
  double smoothness = 1;  // mean of exp(-(16 offset² / spacing of the iso-points²)) of the points,
                          // offset along the normal, ]0, 1]

  // Density times smoothness, points a square metre: the confidence of Wu et al., "Quality-driven
  // Poisson-guided Autoscanning" (2014), as we read it.
  double ScannerConfidence() const { return smoothness / (spacing_m * spacing_m); }
};

struct JudgedPoint {
  IsoPoint point;
  double true_error_m = 0;  // of the dense model, over the truth that the point stands for
  double distance_to_truth_m = 0;
  ErrorCues cues;  // what the predicted error was made from
  CueLogs around;  // and the probability that the final model fails
  // Other rules.
  CoverageClass paper = CoverageClass::kUncovered;  // the paper's classification
  CloudAround cloud;
};

// What the map says of a place of the truth.
struct JudgedPlace {
  double score = 0;  // of the nearest iso-point within their spacing that faces the same way; 0
                     // without one: no place of the map's surface is further from its iso-points
  bool is_covered = false;  // that iso-point is
  double error_m = 0;       // of the dense model
};

struct JudgedFlight {
  std::vector<JudgedPoint> points;  // not ignored
  std::vector<JudgedPlace> places;  // evenly over the truth, but for where the map ignores it
  double spacing_m = 0;             // of the iso-points
  double unrepresented = 0;         // share of the truth with no iso-point nearer than 1.5 spacings

  // Share of the iso-points whose nearest truth is further than 1.5 spacings: surface that is not
  // there.
  double FarShare() const;
};

// Truth is sampled in the region, three times as closely as the iso-points. What an iso-point
// stands for is the nearest sample of the truth that faces the same way, however far, and those
// within 0.6 spacings of that one which face the same way too. Its true error is the median of
// their distances to the surface of the dense model: "bad" means that half of its disk is bad or
// missing.
JudgedFlight Judge(const Site& site, const FlightModels& models, const CoverageOptions& options,
                   const JobControl& job);

}  // namespace colmap_ext
