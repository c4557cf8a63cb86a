#include "true_site.h"

#include <cmath>
#include <random>

#include "colmap_ext/coverage/iso_points.h"
#include "colmap_ext/coverage/projection_ratio.h"
#include "colmap_ext/mission/patterns.h"
#include "colmap_ext/session/presets.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/parallel.h"
#include "nbv/view_pool.h"

namespace colmap_ext {
namespace {

constexpr double kCoarseTextures = 16;  // pictures are not looked at

// The scene without the ground far from the model.
TriangleMesh Cropped(const TriangleMesh& mesh, const BoundingBox& model) {
  const double margin = 0.1 * model.diagonal().norm();
  const BoundingBox box(model.min().array() - margin, model.max().array() + margin);
  TriangleMesh cropped;
  cropped.vertices = mesh.vertices;
  for (const Eigen::Vector3i& face : mesh.faces) {
    BoundingBox bounds;
    for (int k = 0; k < 3; ++k) bounds.extend(mesh.vertices[static_cast<std::size_t>(face[k])]);
    if (box.intersects(bounds)) cropped.faces.push_back(face);
  }
  return cropped;
}

double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) area += FaceArea(mesh, f);
  return area;
}

CoverageOptions WithSpacing(CoverageOptions options, double model_area_m2) {
  constexpr double kPoints = 6000;
  options.iso_point_spacing_m = std::sqrt(0.7 * model_area_m2 / kPoints);
  return options;
}

}  // namespace

StageOptions OptionsFor(const std::string& scene, const OptionSet& set, const StageOptions& given) {
  StageOptions options = given;
  ApplyPreset(scene == "boxes" ? "indoor" : "outdoor", set, &options);
  return options;
}

CoverageCounter::CoverageCounter(const Surface& surface, const RegionOfInterest& region,
                                 const CoverageOptions& options)
    : options_(options), engine_(surface.mesh, options.visibility) {
  IsoPoints iso = SampleIsoPoints(surface, options.iso_point_spacing_m, options.seed);
  map_.points = std::move(iso.points);
  map_.disk_area_m2 = iso.disk_area_m2;
  map_.min_projection_ratio = options.MinProjectionRatio();
  for (IsoPoint& point : map_.points) {
    if (!region.Contains(point.position)) point.coverage = CoverageClass::kIgnored;
  }
  good_directions_.resize(map_.points.size());
}

void CoverageCounter::Add(const PosedPhoto& photo) {
  const double min_cos = std::cos(DegToRad(options_.max_angle_deg));
  const double max_cos = std::cos(DegToRad(options_.min_angle_deg));
  const Eigen::Vector3d center = CameraCenter(photo.cam_from_world);
  ParallelFor(map_.points.size(), [&](std::size_t i) {
    IsoPoint& point = map_.points[i];
    if (point.coverage == CoverageClass::kIgnored) return;
    if (ProjectionRatio(photo.camera, photo.cam_from_world, point.position, point.normal) <=
            map_.min_projection_ratio ||
        !engine_.IsVisible(photo.camera, photo.cam_from_world, point.position, point.normal)) {
      return;
    }
    const Eigen::Vector3d direction = (center - point.position).normalized();
    for (const Eigen::Vector3d& other : good_directions_[i]) {
      const double cos_angle = other.dot(direction);
      if (cos_angle >= min_cos && cos_angle <= max_cos) point.coverage = CoverageClass::kCovered;
    }
    good_directions_[i].push_back(direction);
    ++point.num_good_views;
  });
}

TrueSite::TrueSite(const std::string& scene, std::uint64_t seed, const StageOptions& options)
    : scene_(scene), seed_(seed), options_(options) {
  const TexturedScene textured = MakeScene(scene, seed, kCoarseTextures);
  const TriangleMesh model = textured.Truth().model;
  region_ = {BoundsOf(model)};
  surface_.mesh = Cropped(textured.mesh, region_.box);
  options_.coverage = WithSpacing(options.coverage, AreaOf(model));
  options_.coverage.seed = seed;
  options_.nbv.seed = seed;
}

PosedPhoto TrueSite::Photograph(const PlannedView& view) const {
  std::mt19937_64 random(seed_ * 7919 + static_cast<std::uint64_t>(view.id));
  std::normal_distribution<double> error(0, options_.simulation.gps_noise_m);
  PosedPhoto photo;
  photo.name = std::to_string(view.id);
  photo.camera = options_.simulation.LowCamera();
  photo.cam_from_world = CamFromWorld(
      view.position + Eigen::Vector3d(error(random), error(random), error(random)), view.direction);
  return photo;
}

std::vector<PosedPhoto> TrueSite::FirstFlight() const {
  std::vector<PosedPhoto> photos;
  for (const PlannedView& view : InitialRectangle(region_, options_.initial_flight)) {
    photos.push_back(Photograph(view));
  }
  return photos;
}

std::size_t TrueSite::CountCoverable(const std::vector<PosedPhoto>& photos) const {
  NextBestViewOptions nbv = options_.nbv;
  nbv.strategy = "submodular";
  nbv.num_positions = 6000;
  nbv.views_a_position = 8;
  const CoverageMap empty = NewCounter().map();
  const VisibilityEngine engine(surface_.mesh, options_.coverage.visibility);
  ViewPlanInput input{empty, surface_.mesh, photos};
  input.camera = options_.simulation.LowCamera();
  SearchContext context{
      nbv, input, engine, empty.min_projection_ratio, region_.box.min().z() + nbv.min_altitude_m,
      {},  {}};
  for (int pitch = -90; pitch <= 30; pitch += 10) context.pitches_rad.push_back(DegToRad(pitch));
  for (int yaw = 0; yaw < 16; ++yaw) context.yaws_rad.push_back(2 * M_PI * yaw / 16);
  const std::vector<std::size_t> wanted = IndicesOfWanted(empty);
  UncoveredPoints points(empty, wanted, nbv);
  CoverageCounter counter = NewCounter();
  for (const PosedPhoto& photo : photos) counter.Add(photo);
  for (const PoolView& view : BuildViewPool(context, points).views) {
    for (const std::uint32_t i : view.seen) {
      if (!points.IsPredictedCovered(i)) points.AddGoodView(i, view.position);
    }
  }
  std::size_t coverable = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const bool is_covered = counter.map().points[wanted[i]].coverage == CoverageClass::kCovered;
    if (is_covered || points.IsPredictedCovered(i)) ++coverable;
  }
  return coverable;
}

}  // namespace colmap_ext
