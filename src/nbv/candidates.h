#pragma once

#include <cstdint>
#include <vector>

#include "nbv/search_context.h"
#include "nbv/uncovered_points.h"

namespace colmap_ext {

struct SeenPoint {
  std::size_t point = 0;
  double projection_ratio = 0;
};

struct Candidate {
  Eigen::Vector3d position;
  ViewDirection direction;
  std::vector<SeenPoint> seen;  // uncovered points seen at >= γ_min
};

// A free position of a plane's grid. What its views share is found out once: rays to points do not
// depend on yaw or pitch, nor on what was chosen since.
struct PlanePlace {
  Eigen::Vector3d position;
  std::vector<ViewDirection> directions;  // admissible; pitches outer, yaws inner
  std::vector<std::uint32_t> visible;     // points that some of them sees and nothing hides
};

// The positions (every `step`-th of the grid in x and y, 1: all) of the plane at `altitude_m` that
// have admissible directions with one of `pitches_rad` and see something, from south to north, west
// to east. Points whose weight is 0 there are left out.
std::vector<PlanePlace> PlacesOnPlane(const SearchContext& context, const UncoveredPoints& points,
                                      const std::vector<Anchor>& anchors, double altitude_m,
                                      const std::vector<double>& pitches_rad, int step);

// The best weighted score among the views of `places` for each of `pitches_rad`; 0 where there is
// none.
std::vector<double> BestScores(const SearchContext& context, const UncoveredPoints& points,
                               const std::vector<PlanePlace>& places,
                               const std::vector<double>& pitches_rad);

// The views of `places` that see something, in their order.
std::vector<Candidate> CandidatesOf(const SearchContext& context, const UncoveredPoints& points,
                                    const std::vector<PlanePlace>& places);

// What one view sees.
Candidate EvaluateCandidate(const SearchContext& context, const UncoveredPoints& points,
                            const Eigen::Vector3d& position, const ViewDirection& direction);

// Sum of the projection ratios (the paper's score), and the same weighted by what the points still
// need and by the sun.
double PlainScore(const Candidate& candidate);
double WeightedScore(const SearchContext& context, const Candidate& candidate,
                     const UncoveredPoints& points);

}  // namespace colmap_ext
