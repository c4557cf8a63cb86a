#include "nbv/candidates.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "nbv/view_fan.h"

namespace colmap_ext {
namespace {

// More than the path planner's margin of proof, so that it can prove to reach what is planned here.
constexpr double kClearanceMargin_m = 0.05;

// The directions that are near to some anchor within reach of `position`; pitches outer, yaws
// inner.
std::vector<ViewDirection> AdmissibleDirections(const SearchContext& context,
                                                const std::vector<Anchor>& anchors,
                                                const Eigen::Vector3d& position,
                                                const std::vector<double>& pitches_rad) {
  std::vector<const Anchor*> near;
  for (const Anchor& anchor : anchors) {
    if ((anchor.position - position).norm() <= context.options.max_distance_to_existing_m) {
      near.push_back(&anchor);
    }
  }
  std::vector<ViewDirection> directions;
  for (const double pitch : pitches_rad) {
    for (const double yaw : context.yaws_rad) {
      const bool is_near = std::any_of(near.begin(), near.end(), [&](const Anchor* anchor) {
        return IsNearInAngle(context.options, anchor->direction.pitch_rad, pitch) &&
               IsNearInAngle(context.options, anchor->direction.yaw_rad, yaw);
      });
      if (is_near) directions.push_back({yaw, pitch});
    }
  }
  return directions;
}

// The positions of the grid: multiples of the spacing, so that they are the same in every
// iteration, around the anchors that reach the plane.
std::vector<Eigen::Vector3d> GridAround(const std::vector<Anchor>& anchors, double altitude_m,
                                        const NextBestViewOptions& options) {
  Eigen::AlignedBox2d box;
  for (const Anchor& anchor : anchors) {
    if (std::abs(anchor.position.z() - altitude_m) <= options.max_distance_to_existing_m) {
      box.extend(Eigen::Vector2d(anchor.position.head<2>()));
    }
  }
  if (box.isEmpty()) return {};
  const double spacing = options.grid_spacing_m;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(options.max_distance_to_existing_m);
  const Eigen::Vector2d first = ((box.min() - margin) / spacing).array().ceil() * spacing;
  const Eigen::Vector2d last = box.max() + margin;
  const auto columns = static_cast<int>(std::floor((last.x() - first.x()) / spacing)) + 1;
  const auto rows = static_cast<int>(std::floor((last.y() - first.y()) / spacing)) + 1;
  std::vector<Eigen::Vector3d> positions;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      positions.emplace_back(first.x() + column * spacing, first.y() + row * spacing, altitude_m);
    }
  }
  return positions;
}

// The weighted score of each direction, without lists.
std::vector<double> WeightedScores(const SearchContext& context, const UncoveredPoints& points,
                                   const Eigen::Vector3d& position,
                                   const std::vector<ViewDirection>& directions) {
  std::vector<double> scores(directions.size(), 0);
  ViewFan fan(context, directions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!fan.LookAt(position, points.position(i), points.normal(i))) continue;
    const double weight = points.WeightFrom(i, position);
    if (weight <= 0 ||
        !context.engine.IsUnoccluded(position, points.position(i), points.normal(i))) {
      continue;
    }
    for (const auto& [k, ratio] : fan.seen()) scores[k] += weight * ratio;
  }
  return scores;
}

}  // namespace

bool IsNearInAngle(const NextBestViewOptions& options, double a_rad, double b_rad) {
  // 1e-9: an angle that is the limit in degrees must not fail by rounding.
  return std::abs(NormalizeAngle(a_rad - b_rad)) <=
         DegToRad(options.max_angle_to_existing_deg) + 1e-9;
}

bool IsFreePosition(const SearchContext& context, const Eigen::Vector3d& position) {
  if (position.z() < context.lowest_altitude_m) return false;
  const double max_altitude_m = context.options.max_altitude_m;
  if (max_altitude_m != 0 && position.z() > max_altitude_m) return false;
  const double least_m = context.options.safe_distance_m + kClearanceMargin_m;
  if (context.engine.ray_scene().DistanceToSurface(position, least_m + 1) < least_m) return false;
  return !context.may_fly || context.may_fly(position);
}

double UsefulRange(const SearchContext& context) {
  const double max_range_m = context.options.max_range_m;
  if (context.min_projection_ratio <= 0) return max_range_m;
  // γ = fx fy cosθ / (r² cos³α) at the angle α off the optical axis; largest in a corner.
  const PinholeCamera& camera = context.camera;
  double stretch = 0;  // 1 / cosα
  for (const double u : {0.0, static_cast<double>(camera.width)}) {
    for (const double v : {0.0, static_cast<double>(camera.height)}) {
      stretch = std::max(stretch, camera.Ray({u, v}).norm());
    }
  }
  return std::min(max_range_m, std::sqrt(camera.fx * camera.fy * stretch * stretch * stretch /
                                         context.min_projection_ratio));
}

std::vector<Candidate> EvaluatePosition(const SearchContext& context, const UncoveredPoints& points,
                                        const Eigen::Vector3d& position,
                                        const std::vector<ViewDirection>& directions) {
  std::vector<Candidate> candidates(directions.size());
  for (std::size_t k = 0; k < directions.size(); ++k) {
    candidates[k].position = position;
    candidates[k].direction = directions[k];
  }
  ViewFan fan(context, directions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!fan.LookAt(position, points.position(i), points.normal(i)) ||
        !context.engine.IsUnoccluded(position, points.position(i), points.normal(i))) {
      continue;
    }
    for (const auto& [k, ratio] : fan.seen()) candidates[k].seen.push_back({i, ratio});
  }
  return candidates;
}

std::vector<Candidate> EvaluatePlane(const SearchContext& context, const UncoveredPoints& points,
                                     const std::vector<Anchor>& anchors, double altitude_m,
                                     const std::vector<double>& pitches_rad) {
  const std::vector<Eigen::Vector3d> positions = GridAround(anchors, altitude_m, context.options);
  std::vector<std::vector<Candidate>> by_position(positions.size());
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    const std::vector<ViewDirection> directions =
        AdmissibleDirections(context, anchors, positions[i], pitches_rad);
    if (directions.empty() || !IsFreePosition(context, positions[i])) return;
    by_position[i] = EvaluatePosition(context, points, positions[i], directions);
  });
  std::vector<Candidate> candidates;
  for (std::vector<Candidate>& some : by_position) {
    for (Candidate& candidate : some) {
      if (!candidate.seen.empty()) candidates.push_back(std::move(candidate));
    }
  }
  return candidates;
}

std::vector<double> BestScoresOnPlane(const SearchContext& context, const UncoveredPoints& points,
                                      const std::vector<Anchor>& anchors, double altitude_m,
                                      const std::vector<double>& pitches_rad) {
  const std::vector<Eigen::Vector3d> positions = GridAround(anchors, altitude_m, context.options);
  std::vector<std::vector<double>> by_position(positions.size());
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    const std::vector<ViewDirection> directions =
        AdmissibleDirections(context, anchors, positions[i], pitches_rad);
    if (directions.empty() || !IsFreePosition(context, positions[i])) return;
    const std::vector<double> scores = WeightedScores(context, points, positions[i], directions);
    by_position[i].resize(pitches_rad.size(), 0);
    for (std::size_t k = 0; k < directions.size(); ++k) {
      for (std::size_t p = 0; p < pitches_rad.size(); ++p) {
        if (directions[k].pitch_rad != pitches_rad[p]) continue;
        by_position[i][p] = std::max(by_position[i][p], scores[k]);
      }
    }
  });
  std::vector<double> best(pitches_rad.size(), 0);
  for (const std::vector<double>& scores : by_position) {
    for (std::size_t p = 0; p < scores.size(); ++p) best[p] = std::max(best[p], scores[p]);
  }
  return best;
}

double PlainScore(const Candidate& candidate) {
  double score = 0;
  for (const SeenPoint& seen : candidate.seen) score += seen.projection_ratio;
  return score;
}

double WeightedScore(const Candidate& candidate, const UncoveredPoints& points) {
  double score = 0;
  for (const SeenPoint& seen : candidate.seen) {
    score += seen.projection_ratio * points.WeightFrom(seen.point, candidate.position);
  }
  return score;
}

}  // namespace colmap_ext
