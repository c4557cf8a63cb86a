#include "nbv/candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "colmap_ext/util/parallel.h"
#include "nbv/view_fan.h"

namespace colmap_ext {
namespace {

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
                                        const NextBestViewOptions& options, int step) {
  Eigen::AlignedBox2d box;
  for (const Anchor& anchor : anchors) {
    if (std::abs(anchor.position.z() - altitude_m) <= options.max_distance_to_existing_m) {
      box.extend(Eigen::Vector2d(anchor.position.head<2>()));
    }
  }
  if (box.isEmpty()) return {};
  const double spacing = options.grid_spacing_m * step;
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

std::vector<std::uint32_t> VisiblePoints(const SearchContext& context,
                                         const UncoveredPoints& points,
                                         const Eigen::Vector3d& position,
                                         const std::vector<ViewDirection>& directions) {
  std::vector<std::uint32_t> visible;
  ViewFan fan(context, directions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!fan.LookAt(position, points.position(i), points.normal(i)) ||
        points.WeightFrom(i, position) <= 0 ||
        !context.engine.IsUnoccluded(position, points.position(i), points.normal(i))) {
      continue;
    }
    visible.push_back(static_cast<std::uint32_t>(i));
  }
  return visible;
}

// The weighted score of each direction of the place.
std::vector<double> ScoresAt(const SearchContext& context, const UncoveredPoints& points,
                             const PlanePlace& place) {
  std::vector<double> scores(place.directions.size(), 0);
  ViewFan fan(context, place.directions);
  for (const std::uint32_t i : place.visible) {
    const double weight = points.WeightFrom(i, place.position);
    if (weight <= 0 || !fan.LookAt(place.position, points.position(i), points.normal(i))) continue;
    for (const auto& [k, ratio] : fan.seen()) scores[k] += weight * ratio;
  }
  for (std::size_t k = 0; k < scores.size(); ++k) {
    scores[k] *= SunFactor(context.options, place.directions[k]);
  }
  return scores;
}

std::vector<Candidate> CandidatesAt(const SearchContext& context, const UncoveredPoints& points,
                                    const PlanePlace& place) {
  std::vector<Candidate> candidates;
  for (const ViewDirection& direction : place.directions) {
    candidates.push_back({place.position, direction, {}});
  }
  ViewFan fan(context, place.directions);
  for (const std::uint32_t i : place.visible) {
    if (!fan.LookAt(place.position, points.position(i), points.normal(i))) continue;
    for (const auto& [k, ratio] : fan.seen()) candidates[k].seen.push_back({i, ratio});
  }
  return candidates;
}

}  // namespace

std::vector<PlanePlace> PlacesOnPlane(const SearchContext& context, const UncoveredPoints& points,
                                      const std::vector<Anchor>& anchors, double altitude_m,
                                      const std::vector<double>& pitches_rad, int step) {
  const std::vector<Eigen::Vector3d> positions =
      GridAround(anchors, altitude_m, context.options, step);
  std::vector<PlanePlace> all(positions.size());
  ParallelFor(positions.size(), [&](std::size_t i) {
    PlanePlace& place = all[i];
    place.position = positions[i];
    place.directions = AdmissibleDirections(context, anchors, positions[i], pitches_rad);
    if (place.directions.empty() || !IsFreePosition(context, positions[i])) return;
    place.visible = VisiblePoints(context, points, positions[i], place.directions);
  });
  std::vector<PlanePlace> places;
  for (PlanePlace& place : all) {
    if (!place.visible.empty()) places.push_back(std::move(place));
  }
  return places;
}

std::vector<double> BestScores(const SearchContext& context, const UncoveredPoints& points,
                               const std::vector<PlanePlace>& places,
                               const std::vector<double>& pitches_rad) {
  std::vector<std::vector<double>> by_place(places.size());
  ParallelFor(places.size(), [&](std::size_t i) {
    const std::vector<double> scores = ScoresAt(context, points, places[i]);
    by_place[i].resize(pitches_rad.size(), 0);
    for (std::size_t k = 0; k < scores.size(); ++k) {
      for (std::size_t p = 0; p < pitches_rad.size(); ++p) {
        if (places[i].directions[k].pitch_rad != pitches_rad[p]) continue;
        by_place[i][p] = std::max(by_place[i][p], scores[k]);
      }
    }
  });
  std::vector<double> best(pitches_rad.size(), 0);
  for (const std::vector<double>& scores : by_place) {
    for (std::size_t p = 0; p < scores.size(); ++p) best[p] = std::max(best[p], scores[p]);
  }
  return best;
}

std::vector<Candidate> CandidatesOf(const SearchContext& context, const UncoveredPoints& points,
                                    const std::vector<PlanePlace>& places) {
  std::vector<std::vector<Candidate>> by_place(places.size());
  ParallelFor(places.size(),
              [&](std::size_t i) { by_place[i] = CandidatesAt(context, points, places[i]); });
  std::vector<Candidate> candidates;
  for (std::vector<Candidate>& some : by_place) {
    for (Candidate& candidate : some) {
      if (!candidate.seen.empty()) candidates.push_back(std::move(candidate));
    }
  }
  return candidates;
}

Candidate EvaluateCandidate(const SearchContext& context, const UncoveredPoints& points,
                            const Eigen::Vector3d& position, const ViewDirection& direction) {
  PlanePlace place{position, {direction}, {}};
  place.visible = VisiblePoints(context, points, position, place.directions);
  return CandidatesAt(context, points, place).front();
}

double PlainScore(const Candidate& candidate) {
  double score = 0;
  for (const SeenPoint& seen : candidate.seen) score += seen.projection_ratio;
  return score;
}

double WeightedScore(const SearchContext& context, const Candidate& candidate,
                     const UncoveredPoints& points) {
  double score = 0;
  for (const SeenPoint& seen : candidate.seen) {
    score += points.WeightFrom(seen.point, candidate.position) * seen.projection_ratio;
  }
  return score * SunFactor(context.options, candidate.direction);
}

}  // namespace colmap_ext
