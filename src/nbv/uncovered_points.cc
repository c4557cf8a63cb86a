#include "nbv/uncovered_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "colmap_ext/coverage/projection_ratio.h"

namespace colmap_ext {

UncoveredPoints::UncoveredPoints(const CoverageMap& coverage, const NextBestViewOptions& options)
    : stereo_aware_(options.stereo_aware),
      seen_weight_(options.seen_weight),
      cos_min_pair_angle_(std::cos(DegToRad(options.min_pair_angle_deg))),
      cos_max_pair_angle_(std::cos(DegToRad(options.max_pair_angle_deg))) {
  for (const IsoPoint& point : coverage.points) {
    if (point.coverage != CoverageClass::kUncovered) continue;
    positions_.push_back(point.position);
    normals_.push_back(point.normal);
  }
  good_directions_.resize(size());
  is_predicted_covered_.resize(size(), 0);
}

void UncoveredPoints::AddExistingViews(const std::vector<PosedPhoto>& existing,
                                       const VisibilityEngine& engine,
                                       double min_projection_ratio) {
  tbb::parallel_for(std::size_t{0}, size(), [&](std::size_t i) {
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
}

double UncoveredPoints::WeightFrom(std::size_t i, const Eigen::Vector3d& center) const {
  if (is_predicted_covered_[i] != 0) return seen_weight_;
  if (!stereo_aware_ || good_directions_[i].empty()) return 1;
  const Eigen::Vector3d direction = DirectionTo(i, center);
  bool is_repetition = false;
  for (const Eigen::Vector3d& other : good_directions_[i]) {
    const double cos_angle = other.dot(direction);
    if (cos_angle > cos_min_pair_angle_) {
      is_repetition = true;
    } else if (cos_angle >= cos_max_pair_angle_) {
      return 1;  // a good pair
    }
  }
  return is_repetition ? 0 : 1;
}

}  // namespace colmap_ext
