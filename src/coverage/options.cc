#include <cmath>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/coverage/projection_ratio.h"

namespace colmap_ext {

std::string CoverageOptions::Check() const {
  const std::string prefix = "Coverage.";
  if (!(ground_sampling_distance_mm > 0)) {
    return prefix + "ground_sampling_distance_mm must be above 0 (millimetres a pixel)";
  }
  if (min_good_views < 2) return prefix + "min_good_views must be at least 2: stereo needs a pair";
  if (!(min_angle_deg >= 0 && min_angle_deg < max_angle_deg && max_angle_deg <= 180)) {
    return prefix + "min_angle_deg and max_angle_deg must satisfy 0 <= min < max <= 180";
  }
  if (!(strong_spacing_m >= 0)) return prefix + "strong_spacing_m must be >= 0 (0: from the GSD)";
  if (!(unsupported_spacing_m >= 0)) {
    return prefix + "unsupported_spacing_m must be >= 0 (0: geometry decides)";
  }
  if (!(iso_point_spacing_m >= 0)) {
    return prefix + "iso_point_spacing_m must be >= 0 (0: automatic)";
  }
  if (!(target_error_mm >= 0) || !std::isfinite(target_error_mm)) {
    return prefix + "target_error_mm must be >= 0 (mm; 0: no such target)";
  }
  if (!(min_score >= 0 && min_score <= 1)) return prefix + "min_score must be in 0 … 1";
  const std::string complaint = visibility.Check();
  return complaint.empty() ? error_model.Check() : prefix + complaint;
}

double CoverageOptions::MinProjectionRatio() const {
  return ProjectionRatioOfGroundSamplingDistance(ground_sampling_distance_mm);
}

double CoverageOptions::StrongSpacing() const {
  return strong_spacing_m > 0 ? strong_spacing_m : 0.001 * ground_sampling_distance_mm;
}

void BindOptions(OptionSet& set, CoverageOptions* options) {
  const std::string section = "Coverage";
  set.Add(section, "ground_sampling_distance_mm", &options->ground_sampling_distance_mm,
          "wanted resolution on the surface, mm a pixel of these photos; gamma_min = 1 / gsd^2");
  set.Add(section, "min_good_views", &options->min_good_views,
          "good views that a point needs, at least 2");
  set.Add(section, "min_angle_deg", &options->min_angle_deg,
          "smallest angle of a pair of good views, degrees");
  set.Add(section, "max_angle_deg", &options->max_angle_deg,
          "largest angle of a pair of good views, degrees");
  set.Add(section, "strong_spacing_m", &options->strong_spacing_m,
          "points at most this far apart are a strong signal, metres; 0: the ground sampling "
          "distance");
  set.Add(section, "unsupported_spacing_m", &options->unsupported_spacing_m,
          "good views do not count where points are further apart, metres; 0: they always count");
  set.Add(section, "iso_point_spacing_m", &options->iso_point_spacing_m,
          "distance of the samples of the surface, metres; 0: about 7500 samples");
  set.Add(section, "seed", &options->seed, "seed of the samples");
  set.Add(section, "target_error_mm", &options->target_error_mm,
          "covered is where the final model should be right to so much, mm; 0: views and angles "
          "decide");
  set.Add(section, "min_score", &options->min_score,
          "with a target: the probability that is enough, 0 to 1");
  set.Add(section, "epsilon_m", &options->visibility.epsilon_m,
          "roughness of the surface that hides nothing, metres; 0: from the mesh");
  set.Add(section, "max_incidence_deg", &options->visibility.max_incidence_deg,
          "a surface seen at a larger angle from its normal is not seen, degrees, 0 to 90");
  set.Add(section, "border_px", &options->visibility.border_px,
          "width of the image border that is not used, px");
  BindOptions(set, &options->error_model);
}

std::map<std::string, double> ThresholdsOf(const CoverageOptions& options) {
  return {{"ground_sampling_distance_mm", options.ground_sampling_distance_mm},
          {"min_good_views", static_cast<double>(options.min_good_views)},
          {"min_angle_deg", options.min_angle_deg},
          {"max_angle_deg", options.max_angle_deg},
          {"strong_spacing_m", options.StrongSpacing()},
          {"unsupported_spacing_m", options.unsupported_spacing_m},
          {"target_error_mm", options.target_error_mm},
          {"min_score", options.min_score},
          {"max_incidence_deg", options.visibility.max_incidence_deg}};
}

}  // namespace colmap_ext
