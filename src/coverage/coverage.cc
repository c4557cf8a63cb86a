#include "colmap_ext/coverage/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/coverage/iso_points.h"
#include "colmap_ext/coverage/projection_ratio.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr char kStage[] = "coverage";
constexpr double kDefaultTargetMm = 50.8;  // 2 inches, the paper's

// The paper's thresholds in the units of the computation.
struct Thresholds {
  double min_projection_ratio = 0;  // γ_min, px² / m²
  double strong_spacing_m = 0;      // 0: the surface has no signal
  double unsupported_spacing_m = 0;
  std::size_t min_good_views = 0;
  double min_cos = 0;  // of the largest angle
  double max_cos = 0;  // of the smallest angle
  ErrorModel error_model;
};

// What is known of an iso-point before its surroundings are looked at.
struct SeenPoint {
  bool is_inside = false;  // the region
  CueLogs logs;
};

Thresholds MakeThresholds(const CoverageOptions& options, bool has_signal) {
  Thresholds limits;
  limits.min_projection_ratio = options.MinProjectionRatio();
  limits.strong_spacing_m = has_signal ? options.StrongSpacing() : 0.0;
  limits.unsupported_spacing_m = options.unsupported_spacing_m > 0 && has_signal
                                     ? options.unsupported_spacing_m
                                     : std::numeric_limits<double>::infinity();
  limits.min_good_views = static_cast<std::size_t>(options.min_good_views);
  limits.min_cos = std::cos(DegToRad(options.max_angle_deg));
  limits.max_cos = std::cos(DegToRad(options.min_angle_deg));
  limits.error_model = options.error_model;
  return limits;
}

bool HasStereoPair(const std::vector<ViewOfPoint>& views, double min_cos, double max_cos) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      const double cos_angle = views[i].direction.dot(views[j].direction);
      if (cos_angle >= min_cos && cos_angle <= max_cos) return true;
    }
  }
  return false;
}

// The paper's decision for a point inside the region, in its order.
CoverageClass Classify(double sample_spacing_m, const std::vector<ViewOfPoint>& good_views,
                       const Thresholds& limits) {
  if (sample_spacing_m <= limits.strong_spacing_m) return CoverageClass::kCovered;
  if (good_views.size() < limits.min_good_views) return CoverageClass::kUncovered;
  if (sample_spacing_m > limits.unsupported_spacing_m) return CoverageClass::kUncovered;
  return HasStereoPair(good_views, limits.min_cos, limits.max_cos) ? CoverageClass::kCovered
                                                                   : CoverageClass::kUncovered;
}

// The paper's class, and the cues of the predicted error.
SeenPoint LookAt(const std::vector<ViewOfPoint>& views, const Thresholds& limits, IsoPoint* point) {
  std::vector<ViewOfPoint> good_views;
  for (const ViewOfPoint& view : views) {
    point->best_projection_ratio = std::max(point->best_projection_ratio, view.projection_ratio);
    if (view.projection_ratio > limits.min_projection_ratio) good_views.push_back(view);
  }
  point->num_good_views = static_cast<int>(good_views.size());
  point->coverage = Classify(point->sample_spacing_m, good_views, limits);
  const ErrorModel& model = limits.error_model;
  const ErrorCues cues = CuesOf(views, point->scatter_m, DegToRad(model.max_angle_deg));
  point->predicted_error_mm = PredictErrorMm(cues, model);
  return {true, LogsOf(cues, model)};
}

// Scores, and with a target the classes that follow from them.
void Score(const std::vector<SeenPoint>& seen, const CoverageOptions& options,
           std::vector<IsoPoint>* points) {
  std::vector<std::size_t> inside;
  std::vector<Eigen::Vector3d> positions;
  std::vector<CueLogs> logs;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i].is_inside) continue;
    inside.push_back(i);
    positions.push_back((*points)[i].position);
    logs.push_back(seen[i].logs);
  }
  const ErrorModel& model = options.error_model;
  const std::vector<CueLogs> around = MeanLogsAround(positions, logs, model.neighbors);
  const bool has_target = options.target_error_mm > 0;
  const double target_mm = has_target ? options.target_error_mm : kDefaultTargetMm;
  for (std::size_t k = 0; k < inside.size(); ++k) {
    IsoPoint& point = (*points)[inside[k]];
    point.score = ProbabilityWithin(target_mm, point.predicted_error_mm,
                                    FailureProbability(around[k], model), model);
    if (!has_target) continue;
    point.coverage = point.score >= options.min_score && point.score > 0
                         ? CoverageClass::kCovered
                         : CoverageClass::kUncovered;
  }
}

}  // namespace

std::vector<ViewOfPoint> ViewsOf(const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                                 const std::vector<PosedPhoto>& photos,
                                 const std::vector<Eigen::Vector3d>& centers,
                                 const VisibilityEngine& engine) {
  std::vector<ViewOfPoint> views;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const PosedPhoto& photo = photos[i];
    if (!engine.IsInView(photo.camera, photo.cam_from_world, position, normal) ||
        !engine.IsUnoccluded(centers[i], position, normal)) {
      continue;
    }
    views.push_back({(centers[i] - position).normalized(),
                     ProjectionRatio(photo.camera, photo.cam_from_world, position, normal)});
  }
  return views;
}

CoverageMap EvaluateCoverage(const Surface& surface, const std::vector<PosedPhoto>& photos,
                             const RegionOfInterest& region, const CoverageOptions& options,
                             const JobControl& job) {
  ThrowIfInvalid(options.Check());
  job.Progress(kStage, 0, 2);
  IsoPoints iso = SampleIsoPoints(surface, options.iso_point_spacing_m, options.seed);
  const VisibilityEngine engine(surface.mesh, options.visibility);
  const Thresholds limits = MakeThresholds(options, !surface.sample_spacing_m.empty());
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(photos.size());
  for (const PosedPhoto& photo : photos) centers.push_back(CameraCenter(photo.cam_from_world));
  std::vector<SeenPoint> seen(iso.points.size());
  job.Progress(kStage, 1, 2);

  ParallelFor(iso.points.size(), [&](std::size_t i) {
    if (job.IsCancelled()) return;
    IsoPoint& point = iso.points[i];
    if (!region.Contains(point.position)) {
      point.coverage = CoverageClass::kIgnored;
      return;
    }
    seen[i] =
        LookAt(ViewsOf(point.position, point.normal, photos, centers, engine), limits, &point);
  });
  job.ThrowIfCancelled();
  Score(seen, options, &iso.points);
  job.Progress(kStage, 2, 2);

  CoverageMap map;
  map.points = std::move(iso.points);
  map.disk_area_m2 = iso.disk_area_m2;
  map.min_projection_ratio = limits.min_projection_ratio;
  map.target_error_mm = options.target_error_mm;
  return map;
}

}  // namespace colmap_ext
