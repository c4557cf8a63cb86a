#include "colmap_ext/sim/drone_site.h"

#include <algorithm>
#include <cstdio>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kComfortable_m = 8;  // from the model; more is not better
constexpr double kAround_m = 0.9;     // from everything, a metre above the ground
constexpr int kSteps = 80;            // of the search, along each side

}  // namespace

DroneSite::DroneSite(const TexturedScene& scene)
    : bounds_(BoundsOf(scene.mesh)),
      model_bounds_(BoundsOf(scene.Truth().model)),
      scene_(scene.mesh),
      model_(scene.Truth().model) {}

VehicleMotion::GroundHeight DroneSite::Ground() const {
  return [this](const Eigen::Vector3d& position) {
    // From a little above, so that a vehicle that stands does not miss what it stands on.
    const Eigen::Vector3d from = position + Eigen::Vector3d(0, 0, 0.3);
    const auto hit = scene_.Intersect(from, -Eigen::Vector3d::UnitZ(), 0, 1e4);
    return hit ? from.z() - hit->distance_m : bounds_.min().z();
  };
}

double DroneSite::Clearance(const Eigen::Vector3d& position, double max_m) const {
  return model_.DistanceToSurface(position, max_m);
}

Eigen::Vector3d DroneSite::OnSurface(double x, double y) const {
  const Eigen::Vector3d above(x, y, bounds_.max().z() + 1);
  const auto hit = scene_.Intersect(above, -Eigen::Vector3d::UnitZ(), 0, 1e6);
  if (!hit) {
    char text[100];
    std::snprintf(text, sizeof text, "the scene has no ground at %.1f east, %.1f north", x, y);
    throw Error(text);
  }
  return {x, y, above.z() - hit->distance_m};
}

Eigen::Vector3d DroneSite::DefaultHome() const {
  const Eigen::Vector3d size = bounds_.sizes();
  const Eigen::Vector3d middle = model_bounds_.center();
  double best_score = -1e9;
  Eigen::Vector3d best = middle;
  for (int i = 1; i < kSteps; ++i) {
    for (int k = 1; k < kSteps; ++k) {
      const double x = bounds_.min().x() + size.x() * i / kSteps;
      const double y = bounds_.min().y() + size.y() * k / kSteps;
      const auto hit =
          scene_.Intersect({x, y, bounds_.max().z() + 1}, -Eigen::Vector3d::UnitZ(), 0, 1e6);
      if (!hit) continue;
      const Eigen::Vector3d place(x, y, bounds_.max().z() + 1 - hit->distance_m);
      const Eigen::Vector3d above = place + Eigen::Vector3d::UnitZ();
      const double from_model = Clearance(above, kComfortable_m);
      if (from_model < kAround_m || scene_.DistanceToSurface(above, 1) < kAround_m) continue;
      // A roof is no place to stand on, however free.
      if (place.z() > model_bounds_.min().z() + 0.5) continue;
      const double score = from_model - 0.01 * (place - middle).head<2>().norm();
      if (score <= best_score) continue;
      best_score = score;
      best = place;
    }
  }
  if (best_score < 0) {
    throw Error("the scene has no free ground to take off from; give --home EAST,NORTH");
  }
  return best;
}

}  // namespace colmap_ext
