#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "nbv/uncovered_points.h"

namespace colmap_ext {

// A view that new ones may be near to.
struct Anchor {
  Eigen::Vector3d position;
  ViewDirection direction;
};

// What every part of the search needs; nothing here is changed by it.
struct SearchContext {
  const NextBestViewOptions& options;
  const PinholeCamera& camera;
  const VisibilityEngine& engine;
  double min_projection_ratio = 0;
  double lowest_altitude_m = 0;  // z of the world

  // Pitches and yaws that are tried, radians.
  std::vector<double> pitches_rad;
  std::vector<double> yaws_rad;
  const std::function<bool(const Eigen::Vector3d&)>& may_fly;  // null: everywhere
};

struct SeenPoint {
  std::size_t point = 0;
  double projection_ratio = 0;
};

struct Candidate {
  Eigen::Vector3d position;
  ViewDirection direction;
  std::vector<SeenPoint> seen;  // uncovered points seen at >= γ_min
};

// Far enough from the surface, flyable, and within the limits of altitude.
bool IsFreePosition(const SearchContext& context, const Eigen::Vector3d& position);

// Within the nearness of pitch and yaw to existing views.
bool IsNearInAngle(const NextBestViewOptions& options, double a_rad, double b_rad);

// Furthest distance at which the camera can see any point at γ_min, at most max_range_m.
double UsefulRange(const SearchContext& context);

// What the views at `position` in `directions` see, one candidate each, in order. Occlusion is
// tested once for a point, however many directions see it.
std::vector<Candidate> EvaluatePosition(const SearchContext& context, const UncoveredPoints& points,
                                        const Eigen::Vector3d& position,
                                        const std::vector<ViewDirection>& directions);

// All admissible candidates on the plane at `altitude_m` with one of `pitches_rad` that see
// something, from south to north, west to east, then by pitch, then by yaw.
std::vector<Candidate> EvaluatePlane(const SearchContext& context, const UncoveredPoints& points,
                                     const std::vector<Anchor>& anchors, double altitude_m,
                                     const std::vector<double>& pitches_rad);

// The best weighted score among those candidates for each of `pitches_rad`; 0 where there is none.
// Much cheaper than EvaluatePlane: no lists, and no rays to points that weigh nothing.
std::vector<double> BestScoresOnPlane(const SearchContext& context, const UncoveredPoints& points,
                                      const std::vector<Anchor>& anchors, double altitude_m,
                                      const std::vector<double>& pitches_rad);

// Sum of the projection ratios (the paper's score), and the same weighted by what the points still
// need.
double PlainScore(const Candidate& candidate);
double WeightedScore(const Candidate& candidate, const UncoveredPoints& points);

}  // namespace colmap_ext
