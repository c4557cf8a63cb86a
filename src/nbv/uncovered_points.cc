#include "nbv/uncovered_points.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/coverage/projection_ratio.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kWorthOfOne = 0.25;  // of a single good view, objective of accuracy

}  // namespace

std::vector<std::size_t> IndicesOfUncovered(const CoverageMap& coverage) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < coverage.points.size(); ++i) {
    if (coverage.points[i].coverage == CoverageClass::kUncovered) indices.push_back(i);
  }
  return indices;
}

std::vector<std::size_t> IndicesOfWanted(const CoverageMap& coverage) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < coverage.points.size(); ++i) {
    if (coverage.points[i].coverage != CoverageClass::kIgnored) indices.push_back(i);
  }
  return indices;
}

std::vector<std::size_t> Strided(const std::vector<std::size_t>& indices, std::size_t count) {
  if (indices.size() <= count) return indices;
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < count; ++k) kept.push_back(indices[k * indices.size() / count]);
  return kept;
}

UncoveredPoints::UncoveredPoints(const CoverageMap& coverage,
                                 const std::vector<std::size_t>& indices,
                                 const NextBestViewOptions& options)
    : stereo_aware_(options.stereo_aware && !options.paper_only),
      seen_weight_(options.paper_only ? 1 : options.seen_weight),
      cos_min_pair_angle_(std::cos(DegToRad(options.min_pair_angle_deg))),
      cos_max_pair_angle_(std::cos(DegToRad(options.max_pair_angle_deg))) {
  for (const std::size_t i : indices) {
    positions_.push_back(coverage.points[i].position);
    normals_.push_back(coverage.points[i].normal);
  }
  good_directions_.resize(size());
  is_predicted_covered_.resize(size(), 0);
}

void UncoveredPoints::AddExistingViews(const std::vector<PosedPhoto>& existing,
                                       const VisibilityEngine& engine,
                                       double min_projection_ratio) {
  ParallelFor(size(), [&](std::size_t i) {
    for (const PosedPhoto& photo : existing) {
      if (ProjectionRatio(photo.camera, photo.cam_from_world, positions_[i], normals_[i]) <
          min_projection_ratio) {
        continue;
      }
      if (engine.IsVisible(photo.camera, photo.cam_from_world, positions_[i], normals_[i])) {
        good_directions_[i].push_back(DirectionTo(i, CameraCenter(photo.cam_from_world)));
      }
    }
  });
}

void UncoveredPoints::AddGoodView(std::size_t i, const Eigen::Vector3d& center) {
  const Eigen::Vector3d direction = DirectionTo(i, center);
  for (const Eigen::Vector3d& other : good_directions_[i]) {
    const double cos_angle = other.dot(direction);
    if (cos_angle <= cos_min_pair_angle_ && cos_angle >= cos_max_pair_angle_) {
      is_predicted_covered_[i] = 1;
    }
  }
  good_directions_[i].push_back(direction);
  if (goal_m_ <= 0) return;
  worth_[i] += Gain(i, center);
  good_views_[i].push_back(ViewFrom(i, center));
}

void UncoveredPoints::PreferAccuracy(double focal_squared, double min_projection_ratio) {
  constexpr double kGoodAngle_deg = 15;
  const ViewOfPoint one{Eigen::Vector3d::UnitX(), min_projection_ratio};
  const double angle = DegToRad(kGoodAngle_deg);
  const ViewOfPoint other{{std::cos(angle), std::sin(angle), 0}, min_projection_ratio};
  goal_m_ = TriangulationError(one, other, 1);
  focal_squared_ = focal_squared;
  good_views_.assign(size(), {});
  worth_.assign(size(), 0);
  for (std::size_t i = 0; i < size(); ++i) {
    // Existing views are noted by direction only: at the distance at which γ is the least.
    for (const Eigen::Vector3d& direction : good_directions_[i]) {
      const ViewOfPoint view{direction, min_projection_ratio};
      worth_[i] = std::max(worth_[i], kWorthOfOne);
      for (const ViewOfPoint& known : good_views_[i]) {
        worth_[i] = std::max(worth_[i], WorthOfPair(known, view));
      }
      good_views_[i].push_back(view);
    }
  }
}

ViewOfPoint UncoveredPoints::ViewFrom(std::size_t i, const Eigen::Vector3d& center) const {
  const Eigen::Vector3d offset = center - positions_[i];
  const double distance = offset.norm();
  const double ratio = focal_squared_ * normals_[i].dot(offset) / (distance * distance * distance);
  return {offset / distance, std::max(ratio, 1e-9)};
}

double UncoveredPoints::WorthOfPair(const ViewOfPoint& first, const ViewOfPoint& second) const {
  if (first.direction.dot(second.direction) < cos_max_pair_angle_) return 0;
  const double error_m = TriangulationError(first, second, 1);
  return kWorthOfOne + (1 - kWorthOfOne) * std::min(1.0, goal_m_ / error_m);
}

double UncoveredPoints::Gain(std::size_t i, const Eigen::Vector3d& center) const {
  if (goal_m_ <= 0) return StereoGain(i, center);
  const ViewOfPoint view = ViewFrom(i, center);
  double best = kWorthOfOne;
  for (const ViewOfPoint& known : good_views_[i]) best = std::max(best, WorthOfPair(known, view));
  return std::max(0.0, best - worth_[i]);
}

bool UncoveredPoints::IsSatisfied(std::size_t i) const {
  return goal_m_ > 0 ? worth_[i] >= 1 : is_predicted_covered_[i] != 0;
}

UncoveredPoints::Relation UncoveredPoints::RelationOf(std::size_t i,
                                                      const Eigen::Vector3d& center) const {
  if (good_directions_[i].empty()) return Relation::kFirst;
  const Eigen::Vector3d direction = DirectionTo(i, center);
  Relation relation = Relation::kFarOff;
  for (const Eigen::Vector3d& other : good_directions_[i]) {
    const double cos_angle = other.dot(direction);
    if (cos_angle > cos_min_pair_angle_) {
      relation = Relation::kRepetition;
    } else if (cos_angle >= cos_max_pair_angle_) {
      return Relation::kPair;
    }
  }
  return relation;
}

double UncoveredPoints::WeightFrom(std::size_t i, const Eigen::Vector3d& center) const {
  if (is_predicted_covered_[i] != 0) return seen_weight_;
  if (!stereo_aware_) return 1;
  return RelationOf(i, center) == Relation::kRepetition ? 0 : 1;
}

double UncoveredPoints::StereoGain(std::size_t i, const Eigen::Vector3d& center) const {
  if (is_predicted_covered_[i] != 0) return 0;
  switch (RelationOf(i, center)) {
    case Relation::kFirst:
    case Relation::kPair:
      return 0.5;
    case Relation::kFarOff:
      return 0.25;
    default:
      return 0;
  }
}

}  // namespace colmap_ext
