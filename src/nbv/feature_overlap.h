#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "nbv/search_context.h"

namespace colmap_ext {

// How many features a planned view will share with existing or earlier planned ones: whether SfM
// can register it.
//
// A feature is a sparse point with the directions and distances from which it was seen. A view
// shares it when it lies in the image, nothing hides it, and some earlier view saw it within
// max_feature_angle_deg and at a distance whose ratio is at most max_feature_scale. What a view
// shares it has seen: planned views pass features on. Not every such feature is found again; the
// part that is, is measured on the existing photos, each against all others, and multiplied in.
//
// Without sparse points iso-points of the surface stand for features, as many a photo as one of
// 640 x 368 px typically has.
class FeatureOverlap {
 public:
  explicit FeatureOverlap(const SearchContext& context);

  // Which features a position sees, found out when asked: shared by the views there.
  class Sight {
   private:
    friend class FeatureOverlap;
    std::vector<std::uint8_t> state_;  // 0: not known yet, 1: seen, 2: hidden
  };

  // Predicted number, counted to `enough` at most (what is beyond is not looked at).
  double Shared(const Eigen::Vector3d& position, const ViewDirection& direction, double enough,
                Sight* sight) const;
  double Shared(const Eigen::Vector3d& position, const ViewDirection& direction) const;

  // Whether the view shares min_shared_features, or, where existing photos have few features, half
  // of what they have in the middle; true when the options ask for none.
  bool IsEnough(const Eigen::Vector3d& position, const ViewDirection& direction,
                Sight* sight) const;

  // The view will be there for the ones after it. Returns Shared() of it.
  double AddView(const Eigen::Vector3d& position, const ViewDirection& direction);

 private:
  struct Observation {
    Eigen::Vector3d toward;  // unit, from the feature to the camera
    double distance_m = 0;
    int photo = -1;  // of the existing ones; -1: planned
  };
  struct Feature {
    Eigen::Vector3d position;
    std::vector<Observation> seen_from;
  };

  void TakeSparsePoints(const std::vector<SupportPoint>& points);
  void TakeIsoPoints();
  double FoundAgain() const;
  bool IsMatched(const Feature& feature, const Eigen::Vector3d& position, int but_photo) const;
  bool IsHidden(const Feature& feature, const Eigen::Vector3d& position) const;

  const SearchContext& context_;
  double min_cos_;
  std::vector<Feature> features_;
  double weight_ = 1;  // features that one stands for
  double least_ = 0;   // that a view must share
};

}  // namespace colmap_ext
