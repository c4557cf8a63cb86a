#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/nbv/next_best_views.h"

namespace colmap_ext {

// A view that new ones may be near to.
struct Anchor {
  Eigen::Vector3d position;
  ViewDirection direction;
};

// What every part of the search needs; nothing here is changed by it.
struct SearchContext {
  const NextBestViewOptions& options;
  const ViewPlanInput& input;
  const VisibilityEngine& engine;
  double min_projection_ratio = 0;  // what points are seen at, at least; px² / m²
  double lowest_altitude_m = 0;     // z of the world

  // Pitches and yaws that are tried where they are not free, radians; within the gimbal's.
  std::vector<double> pitches_rad;
  std::vector<double> yaws_rad;

  const PinholeCamera& camera() const { return input.camera; }
};

// Where a position is not free, why; empty when it is: far enough from the surface and near enough,
// flyable, and within all limits.
std::string WhyNotFree(const SearchContext& context, const Eigen::Vector3d& position);
inline bool IsFreePosition(const SearchContext& context, const Eigen::Vector3d& position) {
  return WhyNotFree(context, position).empty();
}

// Whether a way leads there; slower than all else, so asked last.
inline bool MayReach(const SearchContext& context, const Eigen::Vector3d& position) {
  return !context.input.may_reach || context.input.may_reach(position);
}

// Within the nearness of pitch and yaw to existing views.
bool IsNearInAngle(const NextBestViewOptions& options, double a_rad, double b_rad);

// Furthest distance at which the camera can see any point at γ_min, at most max_range_m.
double UsefulRange(const SearchContext& context);

// What a score is multiplied by for the sun: 1 with the sun behind the camera, 1 - sun_weight when
// looking at it, even between in the cosine.
double SunFactor(const NextBestViewOptions& options, const ViewDirection& direction);

}  // namespace colmap_ext
