#include "nbv/feature_overlap.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/parallel.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMinSparsePoints = 100;
constexpr std::size_t kMaxFeatures = 1500;
// COLMAP's SIFT with first_octave 0 has 400 to 700 features that end in the model of a photo of
// 640 x 368 px.
constexpr double kTypicalFeatures = 400;

// Every so many-th, so that no more than kMaxFeatures are left.
std::size_t StrideOf(std::size_t count) { return (count + kMaxFeatures - 1) / kMaxFeatures; }

double MedianOr(const std::vector<double>& values, double otherwise) {
  return values.empty() ? otherwise : MiddleValue(values);
}

}  // namespace

FeatureOverlap::FeatureOverlap(const SearchContext& context)
    : context_(context), min_cos_(std::cos(DegToRad(context.options.max_feature_angle_deg))) {
  if (context.options.min_shared_features <= 0) return;
  least_ = context.options.min_shared_features;
  const std::vector<SupportPoint>* points = context.input.points;
  if (points != nullptr && points->size() >= kMinSparsePoints) {
    TakeSparsePoints(*points);
  } else {
    TakeIsoPoints();
  }
}

void FeatureOverlap::TakeSparsePoints(const std::vector<SupportPoint>& points) {
  const std::size_t stride = StrideOf(points.size());
  for (std::size_t i = 0; i < points.size(); i += stride) {
    Feature feature{points[i].position, {}};
    for (const int photo : points[i].photo_indices) {
      const Eigen::Vector3d offset =
          CameraCenter(context_.input.existing[static_cast<std::size_t>(photo)].cam_from_world) -
          points[i].position;
      feature.seen_from.push_back({offset.normalized(), offset.norm(), photo});
    }
    features_.push_back(std::move(feature));
  }
  weight_ = static_cast<double>(stride) * FoundAgain();
  std::vector<double> counts(context_.input.existing.size(), 0);
  for (const SupportPoint& point : points) {
    for (const int photo : point.photo_indices) ++counts[static_cast<std::size_t>(photo)];
  }
  least_ = std::min(least_, 0.5 * MiddleValue(counts));
}

void FeatureOverlap::TakeIsoPoints() {
  const std::vector<IsoPoint>& points = context_.input.coverage.points;
  const std::vector<PosedPhoto>& photos = context_.input.existing;
  const std::size_t stride = StrideOf(points.size());
  for (std::size_t i = 0; i < points.size(); i += stride) {
    features_.push_back({points[i].position, {}});
  }
  ParallelFor(features_.size(), [&](std::size_t f) {
    const IsoPoint& point = points[f * stride];
    for (std::size_t i = 0; i < photos.size(); ++i) {
      const Rigid3d& pose = photos[i].cam_from_world;
      if (!context_.engine.IsVisible(photos[i].camera, pose, point.position, point.normal)) {
        continue;
      }
      const Eigen::Vector3d offset = CameraCenter(pose) - point.position;
      features_[f].seen_from.push_back({offset.normalized(), offset.norm(), static_cast<int>(i)});
    }
  });
  std::vector<double> counts(photos.size(), 0);
  for (const Feature& feature : features_) {
    for (const Observation& seen : feature.seen_from)
      ++counts[static_cast<std::size_t>(seen.photo)];
  }
  weight_ = kTypicalFeatures / std::max(1.0, MedianOr(counts, 1));
}

// Median over the existing photos of the part of the features predicted for each (by the others)
// that it has.
double FeatureOverlap::FoundAgain() const {
  const std::vector<PosedPhoto>& photos = context_.input.existing;
  std::vector<double> found(photos.size(), -1);
  ParallelFor(photos.size(), [&](std::size_t i) {
    const PosedPhoto& photo = photos[i];
    const Eigen::Vector3d center = CameraCenter(photo.cam_from_world);
    int predicted = 0, is_there = 0;
    for (const Feature& feature : features_) {
      const bool has_it =
          std::any_of(feature.seen_from.begin(), feature.seen_from.end(),
                      [&](const Observation& seen) { return seen.photo == static_cast<int>(i); });
      const Eigen::Vector3d in_cam = photo.cam_from_world * feature.position;
      if (!has_it &&
          (in_cam.z() <= 0 || !photo.camera.Contains(photo.camera.Project(in_cam)) ||
           !IsMatched(feature, center, static_cast<int>(i)) || IsHidden(feature, center))) {
        continue;
      }
      ++predicted;
      if (has_it) ++is_there;
    }
    constexpr int kFewest = 10;
    if (predicted >= kFewest) found[i] = static_cast<double>(is_there) / predicted;
  });
  std::erase_if(found, [](double part) { return part < 0; });
  constexpr double kUnknown = 0.3;
  return MedianOr(found, kUnknown);
}

bool FeatureOverlap::IsMatched(const Feature& feature, const Eigen::Vector3d& position,
                               int but_photo) const {
  const Eigen::Vector3d offset = position - feature.position;
  const double distance = offset.norm();
  const double max_scale = context_.options.max_feature_scale;
  return std::any_of(
      feature.seen_from.begin(), feature.seen_from.end(), [&](const Observation& seen) {
        return (seen.photo != but_photo || seen.photo < 0) &&
               offset.dot(seen.toward) >= min_cos_ * distance &&
               distance <= max_scale * seen.distance_m && seen.distance_m <= max_scale * distance;
      });
}

bool FeatureOverlap::IsHidden(const Feature& feature, const Eigen::Vector3d& position) const {
  // Sparse points are not exactly on the surface: what is just before them hides nothing.
  constexpr double kPartOfDistance = 0.015;
  const double epsilon_m = std::max(4 * context_.engine.epsilon_m(),
                                    kPartOfDistance * (position - feature.position).norm());
  return context_.engine.ray_scene().IsOccluded(position, feature.position, epsilon_m);
}

double FeatureOverlap::Shared(const Eigen::Vector3d& position, const ViewDirection& direction,
                              double enough, Sight* sight) const {
  sight->state_.resize(features_.size(), 0);
  const Rigid3d cam_from_world = CamFromWorld(position, direction);
  const PinholeCamera& camera = context_.camera();
  const double border_px = context_.options.visibility.border_px;
  double shared = 0;
  for (std::size_t f = 0; f < features_.size() && shared < enough; ++f) {
    std::uint8_t& state = sight->state_[f];
    if (state == 2) continue;
    const Eigen::Vector3d in_cam = cam_from_world * features_[f].position;
    if (in_cam.z() <= 0 || !camera.Contains(camera.Project(in_cam), border_px)) continue;
    if (!IsMatched(features_[f], position, -1)) continue;
    if (state == 0) state = IsHidden(features_[f], position) ? 2 : 1;
    if (state == 1) shared += weight_;
  }
  return shared;
}

double FeatureOverlap::Shared(const Eigen::Vector3d& position,
                              const ViewDirection& direction) const {
  Sight sight;
  return Shared(position, direction, std::numeric_limits<double>::infinity(), &sight);
}

bool FeatureOverlap::IsEnough(const Eigen::Vector3d& position, const ViewDirection& direction,
                              Sight* sight) const {
  return least_ <= 0 || Shared(position, direction, least_, sight) >= least_;
}

double FeatureOverlap::AddView(const Eigen::Vector3d& position, const ViewDirection& direction) {
  const Rigid3d cam_from_world = CamFromWorld(position, direction);
  const PinholeCamera& camera = context_.camera();
  const double border_px = context_.options.visibility.border_px;
  double shared = 0;
  for (Feature& feature : features_) {
    const Eigen::Vector3d in_cam = cam_from_world * feature.position;
    if (in_cam.z() <= 0 || !camera.Contains(camera.Project(in_cam), border_px) ||
        !IsMatched(feature, position, -1) || IsHidden(feature, position)) {
      continue;
    }
    shared += weight_;
    const Eigen::Vector3d offset = position - feature.position;
    const Observation seen{offset.normalized(), offset.norm(), -1};
    // One that is as good as there already would only take time.
    constexpr double kCosSame = 0.9962;  // 5 degrees
    constexpr double kSameScale = 1.1;
    const bool is_known = std::any_of(feature.seen_from.begin(), feature.seen_from.end(),
                                      [&](const Observation& other) {
                                        return other.toward.dot(seen.toward) >= kCosSame &&
                                               other.distance_m <= kSameScale * seen.distance_m &&
                                               seen.distance_m <= kSameScale * other.distance_m;
                                      });
    if (!is_known) feature.seen_from.push_back(seen);
  }
  return shared;
}

}  // namespace colmap_ext
