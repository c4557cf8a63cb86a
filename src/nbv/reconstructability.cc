#include "nbv/reconstructability.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

}  // namespace

Reconstructability::Reconstructability(const SearchContext& context, const UncoveredPoints& points,
                                       const std::vector<PosedPhoto>& existing)
    : points_(points),
      max_distance_m_(context.options.max_range_m),
      views_(points.size()),
      h_(points.size(), 0) {
  const double min_ratio = context.input.coverage.min_projection_ratio;
  if (min_ratio > 0) {
    const double at_least_m = std::sqrt(context.camera().fx * context.camera().fy / min_ratio);
    max_distance_m_ = std::min(max_distance_m_, at_least_m);
  }
  ParallelFor(points.size(), [&](std::size_t p) {
    for (const PosedPhoto& photo : existing) {
      if (!context.engine.IsVisible(photo.camera, photo.cam_from_world, points.position(p),
                                    points.normal(p))) {
        continue;
      }
      const PointView view = ViewFrom(p, CameraCenter(photo.cam_from_world));
      h_[p] += SumOfPairs(p, view);
      views_[p].push_back(view);
    }
  });
}

double Reconstructability::OfPair(const PointView& first, const PointView& second,
                                  double max_distance_m) {
  constexpr double kParallaxSlope = 32, kParallax = M_PI / 16;
  constexpr double kMatchSlope = 8, kMatch = M_PI / 4;
  const double angle = std::acos(std::clamp(first.toward.dot(second.toward), -1.0, 1.0));
  const double distance_m = std::max(first.distance_m, second.distance_m);
  const double parallax = Logistic(kParallaxSlope * (angle - kParallax));
  const double resolution = 1 - std::min(distance_m / max_distance_m, 1.0);
  const double match = 1 - Logistic(kMatchSlope * (angle - kMatch));
  return parallax * resolution * match *
         std::max(0.0, std::min(first.cos_incidence, second.cos_incidence));
}

Reconstructability::PointView Reconstructability::ViewFrom(std::size_t point,
                                                           const Eigen::Vector3d& center) const {
  const Eigen::Vector3d offset = center - points_.position(point);
  const double distance_m = offset.norm();
  const Eigen::Vector3d toward = offset / distance_m;
  return {toward, distance_m, toward.dot(points_.normal(point))};
}

double Reconstructability::SumOfPairs(std::size_t point, const PointView& view) const {
  double sum = 0;
  for (const PointView& other : views_[point]) sum += OfPair(other, view, max_distance_m_);
  return sum;
}

double Reconstructability::Total() const {
  double total = 0;
  for (const double h : h_) total += std::min(h, kEnough);
  return total;
}

double Reconstructability::Gain(const Eigen::Vector3d& center,
                                const std::vector<std::uint32_t>& seen) const {
  double gain = 0;
  for (const std::uint32_t point : seen) {
    if (h_[point] >= kEnough) continue;
    const double sum = SumOfPairs(point, ViewFrom(point, center));
    gain += std::min(kEnough, h_[point] + sum) - h_[point];
  }
  return gain;
}

void Reconstructability::Add(const Eigen::Vector3d& center,
                             const std::vector<std::uint32_t>& seen) {
  for (const std::uint32_t point : seen) {
    const PointView view = ViewFrom(point, center);
    h_[point] += SumOfPairs(point, view);
    views_[point].push_back(view);
  }
}

void Reconstructability::Remove(const Eigen::Vector3d& center,
                                const std::vector<std::uint32_t>& seen) {
  for (const std::uint32_t point : seen) {
    const PointView view = ViewFrom(point, center);
    std::vector<PointView>& views = views_[point];
    const auto same = std::find_if(views.begin(), views.end(), [&](const PointView& other) {
      return other.toward == view.toward && other.distance_m == view.distance_m;
    });
    if (same == views.end()) continue;
    views.erase(same);
    h_[point] -= SumOfPairs(point, view);
  }
}

}  // namespace colmap_ext
