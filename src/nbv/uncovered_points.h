#pragma once

#include <Eigen/Core>
#include <vector>

#include "colmap_ext/coverage/error_model.h"
#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/nbv/next_best_views.h"

namespace colmap_ext {

// Indices of the uncovered iso-points of a map.
std::vector<std::size_t> IndicesOfUncovered(const CoverageMap& coverage);
// Of all that are not ignored.
std::vector<std::size_t> IndicesOfWanted(const CoverageMap& coverage);
// At most about `count` of them, evenly over their order.
std::vector<std::size_t> Strided(const std::vector<std::size_t>& indices, std::size_t count);

// Some iso-points of a map (the uncovered ones), and the good views that each of them has: of
// existing photos and of views chosen so far.
class UncoveredPoints {
 public:
  UncoveredPoints(const CoverageMap& coverage, const std::vector<std::size_t>& indices,
                  const NextBestViewOptions& options);

  std::size_t size() const { return positions_.size(); }
  const Eigen::Vector3d& position(std::size_t i) const { return positions_[i]; }
  const Eigen::Vector3d& normal(std::size_t i) const { return normals_[i]; }

  // Notes for every point the photos that are good views of it (visible, ratio >= γ_min).
  void AddExistingViews(const std::vector<PosedPhoto>& existing, const VisibilityEngine& engine,
                        double min_projection_ratio);

  // From now on Gain is that of accuracy: a point is worth 1/4 by its first good view, and the
  // other 3/4 times e0 / e (1 at most) by the pair whose TriangulationError e is smallest, of those
  // that match. e0 is that of a pair at 15 degrees with γ_min each; a view counts with the γ that
  // it would have in the middle of its image. `focal_squared`: fx fy, px².
  void PreferAccuracy(double focal_squared, double min_projection_ratio);

  // What a good view from `center` adds to the point, by the objective; and whether nothing can add
  // to it any more.
  double Gain(std::size_t i, const Eigen::Vector3d& center) const;
  bool IsSatisfied(std::size_t i) const;

  // What a good view from `center` adds to the stereo coverage of the point, which is 1/2 for its
  // first good view and 1/2 for a good pair: 0 for a point that has a pair by chosen views, and for
  // a repetition; 1/4 for a view too far off all others to make a pair.
  double StereoGain(std::size_t i, const Eigen::Vector3d& center) const;

  // Notes that the point gets a good view from `center`.
  void AddGoodView(std::size_t i, const Eigen::Vector3d& center);

  // What a good view of the point from `center` is worth: 0 a repetition, seen_weight when chosen
  // views cover it already, else 1.
  double WeightFrom(std::size_t i, const Eigen::Vector3d& center) const;

  bool IsPredictedCovered(std::size_t i) const { return is_predicted_covered_[i] != 0; }

 private:
  enum class Relation { kFirst, kPair, kRepetition, kFarOff };
  Relation RelationOf(std::size_t i, const Eigen::Vector3d& center) const;
  Eigen::Vector3d DirectionTo(std::size_t i, const Eigen::Vector3d& center) const {
    return (center - positions_[i]).normalized();
  }

  ViewOfPoint ViewFrom(std::size_t i, const Eigen::Vector3d& center) const;
  double WorthOfPair(const ViewOfPoint& first, const ViewOfPoint& second) const;

  bool stereo_aware_;
  double seen_weight_;
  double cos_min_pair_angle_, cos_max_pair_angle_;
  std::vector<Eigen::Vector3d> positions_, normals_;
  // From the point towards its good views, unit.
  std::vector<std::vector<Eigen::Vector3d>> good_directions_;
  std::vector<char> is_predicted_covered_;  // by views chosen in this plan
  // Of the objective of accuracy; else empty, and 0.
  std::vector<std::vector<ViewOfPoint>> good_views_;
  std::vector<double> worth_;
  double focal_squared_ = 0;
  double goal_m_ = 0;  // e0
};

}  // namespace colmap_ext
