// Coverage evaluation (paper, Sec. "Coverage Evaluation"): where the photos suffice for a good
// model.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/coverage/error_model.h"
#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct CoverageOptions {
  // The wanted resolution on the surface, millimetres a pixel, > 0, at the resolution of the photos
  // that are evaluated (the low one): γ_min = 1 / gsd². A view is good when a pixel covers at most
  // gsd² of surface, slant included. The default is what 640 x 368 photos of 480 px focal length
  // give 29 m away seen frontally, or 20 m away on a surface that slants by 60 degrees;
  // full-resolution photos of the same camera resolve finer by the ratio of the widths (20 mm for
  // 1920 px).
  double ground_sampling_distance_mm = 60;
  // Good views that a point needs, >= 2 (paper: 2).
  int min_good_views = 2;
  // Angle between the rays of a pair of good views, degrees, 0 <= min < max <= 180 (paper: 2, 30).
  double min_angle_deg = 2;
  double max_angle_deg = 30;
  // "Strong signal": sample_spacing_m at most this, metres, >= 0 (0: the ground sampling distance;
  // one confident point a wanted pixel, from more than one photo, which neither slanting views nor
  // a single one give).
  double strong_spacing_m = 0;
  // Where the points are further apart than this, good views are not believed: photos are there,
  // yet stereo failed. Metres, >= 0; 0 (the paper): geometry decides.
  double unsupported_spacing_m = 0;
  // Distance of the iso-points, metres, >= 0; 0: about 7500 points.
  double iso_point_spacing_m = 0;
  std::uint64_t seed = 1;  // of the iso-points
  // A point is covered where the final model is expected to be right to so much, mm, >= 0. 0: the
  // thresholds above decide, as in the paper.
  double target_error_mm = 0;
  // With a target: the probability that is enough, 0 … 1.
  double min_score = 0.5;
  ErrorModel error_model;
  VisibilityOptions visibility;

  std::string Check() const;
  // 1 / gsd², px² / m².
  double MinProjectionRatio() const;
  // strong_spacing_m, or what stands for it, metres.
  double StrongSpacing() const;
};

// Section "Coverage" (the visibility options are in it too) and "ErrorModel".
void BindOptions(OptionSet& set, CoverageOptions* options);

// The thresholds of an evaluation by option name, for coverage.json.
std::map<std::string, double> ThresholdsOf(const CoverageOptions& options);

// The photos that see the place (VisibilityEngine), in their order. `centers`: of the photos.
std::vector<ViewOfPoint> ViewsOf(const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                                 const std::vector<PosedPhoto>& photos,
                                 const std::vector<Eigen::Vector3d>& centers,
                                 const VisibilityEngine& engine);

// Classifies iso-points of the surface in the paper's order:
//   outside the region                                   → ignored
//   strong signal (sample_spacing_m small)               → covered
//   fewer than min_good_views views with γ > γ_min       → uncovered
//   no pair of good views with an angle in [min, max]    → uncovered
//   else                                                 → covered
// With a target_error_mm, inside the region the score alone decides: covered where it is at least
// min_score, and some photo sees the point.
// A view of a point is one that VisibilityEngine passes. A surface whose sample_spacing_m is empty
// has no signal: that stage is skipped. predicted_error_mm uses all views of the point, good or
// not; score is the probability that the true error is within target_error_mm (2 inches when it is
// 0), with what is known of the neighbouring iso-points (ErrorModel).
//
// With the same surface and no target, a photo more never turns a covered point uncovered. Parallel
// over points; same input, same map, whatever the number of threads. Throws UsageError for wrong
// options, Error for a surface without area.
CoverageMap EvaluateCoverage(const Surface& surface, const std::vector<PosedPhoto>& photos,
                             const RegionOfInterest& region, const CoverageOptions& options,
                             const JobControl& job);

}  // namespace colmap_ext
