#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/nbv/plane_sweep.h"

namespace colmap_ext {

// The uncovered iso-points of a map, and the good views that each of them has: of existing photos
// and of views chosen so far.
class UncoveredPoints {
 public:
  UncoveredPoints(const CoverageMap& coverage, const NextBestViewOptions& options);

  std::size_t size() const { return positions_.size(); }
  const Eigen::Vector3d& position(std::size_t i) const { return positions_[i]; }
  const Eigen::Vector3d& normal(std::size_t i) const { return normals_[i]; }

  // Notes for every point the photos that are good views of it (visible, ratio >= γ_min).
  void AddExistingViews(const std::vector<PosedPhoto>& existing, const VisibilityEngine& engine,
                        double min_projection_ratio);

  // Notes that the point gets a good view from `center`.
  void AddGoodView(std::size_t i, const Eigen::Vector3d& center);

  // What a good view of the point from `center` is worth: 0 a repetition, seen_weight when chosen
  // views cover it already, else 1.
  double WeightFrom(std::size_t i, const Eigen::Vector3d& center) const;

 private:
  Eigen::Vector3d DirectionTo(std::size_t i, const Eigen::Vector3d& center) const {
    return (center - positions_[i]).normalized();
  }

  bool stereo_aware_;
  double seen_weight_;
  double cos_min_pair_angle_, cos_max_pair_angle_;
  std::vector<Eigen::Vector3d> positions_, normals_;
  // From the point towards its good views, unit.
  std::vector<std::vector<Eigen::Vector3d>> good_directions_;
  std::vector<char> is_predicted_covered_;  // by views chosen in this plan
};

}  // namespace colmap_ext
