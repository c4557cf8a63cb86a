#include <sstream>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/superpixels.h"

namespace colmap_ext {
namespace {

// Collects the first complaint.
class RangeCheck {
 public:
  explicit RangeCheck(std::string section) : section_(std::move(section)) {}

  RangeCheck& In(const char* name, double value, double low, double high) {
    if (complaint_.empty() && !(value >= low && value <= high)) {
      std::ostringstream text;
      text << section_ << "." << name << " is " << value << ", must be in [" << low << ", " << high
           << "]";
      complaint_ = text.str();
    }
    return *this;
  }
  const std::string& complaint() const { return complaint_; }

 private:
  std::string section_;
  std::string complaint_;
};

constexpr double kTiny = 1e-9;  // stands for an open lower bound of 0

}  // namespace

std::string SuperpixelOptions::Check() const {
  return RangeCheck("SuperpixelSegmenter")
      .In("target_polygons", target_polygons, 20, 20000)
      .In("lsd_scale", lsd_scale, 0.2, 1)
      .In("min_segment_px", min_segment_px, 3, 1000)
      .In("anchor_offset_px", anchor_offset_px, 0.5, 10)
      .In("anchor_spacing_px", anchor_spacing_px, 2, 100)
      .In("max_anchor_share", max_anchor_share, 0, 1)
      .In("merge_px", merge_px, 0.1, 4)
      .complaint();
}

void BindOptions(OptionSet& set, SuperpixelOptions* options) {
  const std::string section = "SuperpixelSegmenter";
  set.Add(section, "target_polygons", &options->target_polygons,
          "polygons of a 640x368 photo, scaled by area (20 to 20000)");
  set.Add(section, "lsd_scale", &options->lsd_scale,
          "photo scale for the line segment detector (0.2 to 1)");
  set.Add(section, "min_segment_px", &options->min_segment_px,
          "shorter line segments are ignored (px, 3 to 1000)");
  set.Add(section, "anchor_offset_px", &options->anchor_offset_px,
          "distance of Voronoi anchors from their segment (px, 0.5 to 10)");
  set.Add(section, "anchor_spacing_px", &options->anchor_spacing_px,
          "distance of anchor pairs along a segment (px, 2 to 100)");
  set.Add(section, "max_anchor_share", &options->max_anchor_share,
          "share of polygons that may lie along segments (0 to 1)");
  set.Add(section, "merge_px", &options->merge_px,
          "vertices joined by a shorter edge become one (px, 0.1 to 4)");
  set.Add(section, "seed", &options->seed, "seed of the point process in flat areas");
}

std::string SuperpixelStereoOptions::Check() const {
  return RangeCheck("SuperpixelStereo")
      .In("smoothness_weight", smoothness_weight, kTiny, 1e6)
      .In("continuity_weight", continuity_weight, kTiny, 1e6)
      .In("color_sigma", color_sigma, 1, 1000)
      .In("min_color_weight", min_color_weight, kTiny, 1)
      .In("robust_passes", robust_passes, 1, 20)
      .In("max_support_px", max_support_px, 1, 1e6)
      .In("num_neighbors", num_neighbors, 1, 50)
      .In("good_angle_deg", good_angle_deg, kTiny, 90)
      .In("max_angle_deg", max_angle_deg, kTiny, 180)
      .In("sigma_position_px", sigma_position_px, kTiny, 1e3)
      .In("sigma_normal_deg", sigma_normal_deg, kTiny, 1e3)
      .In("sigma_view", sigma_view, kTiny, 10)
      .In("occlusion_tolerance", occlusion_tolerance, kTiny, 1)
      .In("fusion_weight", fusion_weight, kTiny, 1e6)
      .In("fusion_passes", fusion_passes, 0, 50)
      .In("fusion_tolerance", fusion_tolerance, 0, 1)
      .In("fusion_moving_share", fusion_moving_share, 0, 1)
      .In("fixed_confidence", fixed_confidence, 0, 1)
      .In("fusion_color_sigma", fusion_color_sigma, 1, 1000)
      .In("fusion_space_tolerance", fusion_space_tolerance, kTiny, 1)
      .In("fusion_step_px", fusion_step_px, 1, 64)
      .In("photometric_weight", photometric_weight, kTiny, 1e6)
      .In("photometric_min_correlation", photometric_min_correlation, 0, 1)
      .In("sigma_photometric", sigma_photometric, kTiny, 1e3)
      .In("keep_tolerance_px", keep_tolerance_px, 0, 100)
      .In("keep_new_points", keep_new_points, 0, 1e6)
      .complaint();
}

void BindOptions(OptionSet& set, SuperpixelStereoOptions* options) {
  const std::string section = "SuperpixelStereo";
  set.Add(section, "smoothness_weight", &options->smoothness_weight,
          "lambda_s, coplanarity of adjacent triangles (> 0)");
  set.Add(section, "continuity_weight", &options->continuity_weight,
          "lambda_c, equal depth at shared vertices (> 0)");
  set.Add(section, "color_sigma", &options->color_sigma,
          "colour difference that weakens both terms (grey levels, 1 to 1000)");
  set.Add(section, "min_color_weight", &options->min_color_weight,
          "colour weight across the strongest edge (0 to 1)");
  set.Add(section, "robust_passes", &options->robust_passes,
          "solves with reweighted SfM points (1 to 20)");
  set.Add(section, "max_support_px", &options->max_support_px,
          "triangles further from every SfM point are marked unsupported (px)");
  set.Add(section, "num_neighbors", &options->num_neighbors, "neighbouring views (1 to 50)");
  set.Add(section, "good_angle_deg", &options->good_angle_deg,
          "triangulation angle from which on a shared point counts fully (degrees)");
  set.Add(section, "max_angle_deg", &options->max_angle_deg,
          "shared points under a larger angle do not count (degrees)");
  set.Add(section, "sigma_position_px", &options->sigma_position_px,
          "sigma_p of the confidence: reprojection difference (px)");
  set.Add(section, "sigma_normal_deg", &options->sigma_normal_deg,
          "sigma_n of the confidence: angle between normals (degrees)");
  set.Add(section, "sigma_view", &options->sigma_view,
          "sigma_v of the confidence: squared cosine of the viewing angle");
  set.Add(section, "occlusion_tolerance", &options->occlusion_tolerance,
          "a neighbour whose depth is smaller by this share is no witness (0 to 1)");
  set.Add(section, "fusion_weight", &options->fusion_weight,
          "lambda_u, agreement with corresponding facets of neighbours (> 0)");
  set.Add(section, "fusion_passes", &options->fusion_passes,
          "passes of multi-view fusion, at most (0 to 50)");
  set.Add(section, "fusion_tolerance", &options->fusion_tolerance,
          "a facet moves when its depth changes by more than this share (0 to 1)");
  set.Add(section, "fusion_moving_share", &options->fusion_moving_share,
          "fusion ends when a smaller share of every view's facets moves (0 to 1)");
  set.Add(section, "fixed_confidence", &options->fixed_confidence,
          "facets with a higher confidence keep their depth in fusion (0 to 1)");
  set.Add(section, "fusion_color_sigma", &options->fusion_color_sigma,
          "colour proximity of corresponding facets (grey levels, 1 to 1000)");
  set.Add(section, "fusion_space_tolerance", &options->fusion_space_tolerance,
          "corresponding facets agree within this share of depth (0 to 1)");
  set.Add(section, "fusion_step_px", &options->fusion_step_px,
          "pixel grid on which corresponding facets are looked up (px, 1 to 64)");
  set.Add(section, "photometric", &options->photometric,
          "compare facets with the neighbouring photos, and mend those that disagree (0 or 1)");
  set.Add(section, "photometric_weight", &options->photometric_weight,
          "lambda_p, of what the photos say about a facet's plane (> 0)");
  set.Add(section, "photometric_min_correlation", &options->photometric_min_correlation,
          "planes that correlate less with the neighbouring photos say nothing (0 to 1)");
  set.Add(section, "sigma_photometric", &options->sigma_photometric,
          "sigma_c of the confidence: missing correlation with the neighbouring photos");
  set.Add(section, "keep_tolerance_px", &options->keep_tolerance_px,
          "when photos come, others keep their mesh while nothing moved by more in a neighbour "
          "(px, 0 to 100; 0: all are solved again)");
  set.Add(section, "keep_new_points", &options->keep_new_points,
          "and while they gained at most this share of SfM points");
}

std::string PointSamplerOptions::Check() const {
  return RangeCheck("PointSampler")
      .In("step_px", step_px, 1, 64)
      .In("min_confidence", min_confidence, 0, 1)
      .In("free_space_tolerance", free_space_tolerance, kTiny, 1)
      .complaint();
}

void BindOptions(OptionSet& set, PointSamplerOptions* options) {
  const std::string section = "PointSampler";
  set.Add(section, "step_px", &options->step_px, "a point every so many pixels (px, 1 to 64)");
  set.Add(section, "min_confidence", &options->min_confidence,
          "facets with a higher confidence give points (0 to 1)");
  set.Add(section, "free_space_tolerance", &options->free_space_tolerance,
          "points that neighbours see through by this share of depth are dropped (0 to 1)");
}

}  // namespace colmap_ext
