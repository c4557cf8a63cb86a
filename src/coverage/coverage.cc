#include "colmap_ext/coverage/coverage.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/coverage/iso_points.h"
#include "colmap_ext/coverage/projection_ratio.h"
#include "colmap_ext/util/error.h"

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
  double target_error_mm = 0;
  ErrorModel error_model;
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
  limits.target_error_mm = options.target_error_mm;
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

CoverageClass ClassByError(double predicted_mm, double target_mm) {
  return predicted_mm >= 0 && predicted_mm <= target_mm ? CoverageClass::kCovered
                                                        : CoverageClass::kUncovered;
}

void EvaluatePoint(const std::vector<ViewOfPoint>& views, const Thresholds& limits,
                   IsoPoint* point) {
  std::vector<ViewOfPoint> good_views;
  for (const ViewOfPoint& view : views) {
    point->best_projection_ratio = std::max(point->best_projection_ratio, view.projection_ratio);
    if (view.projection_ratio > limits.min_projection_ratio) good_views.push_back(view);
  }
  point->num_good_views = static_cast<int>(good_views.size());
  const ErrorModel& model = limits.error_model;
  const double spacing_m = limits.strong_spacing_m > 0 ? point->sample_spacing_m : 0.0;
  point->predicted_error_mm =
      PredictErrorMm(CuesOf(views, spacing_m, DegToRad(model.max_angle_deg)), model);
  point->score =
      ProbabilityWithin(limits.target_error_mm > 0 ? limits.target_error_mm : kDefaultTargetMm,
                        point->predicted_error_mm, model);
  point->coverage = limits.target_error_mm > 0
                        ? ClassByError(point->predicted_error_mm, limits.target_error_mm)
                        : Classify(point->sample_spacing_m, good_views, limits);
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
  job.Progress(kStage, 1, 2);

  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, iso.points.size(), 64),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      if (job.IsCancelled()) return;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        IsoPoint& point = iso.points[i];
                        if (!region.Contains(point.position)) {
                          point.coverage = CoverageClass::kIgnored;
                          continue;
                        }
                        EvaluatePoint(
                            ViewsOf(point.position, point.normal, photos, centers, engine), limits,
                            &point);
                      }
                    });
  job.ThrowIfCancelled();
  job.Progress(kStage, 2, 2);

  CoverageMap map;
  map.points = std::move(iso.points);
  map.disk_area_m2 = iso.disk_area_m2;
  map.min_projection_ratio = limits.min_projection_ratio;
  map.target_error_mm = limits.target_error_mm;
  return map;
}

}  // namespace colmap_ext
