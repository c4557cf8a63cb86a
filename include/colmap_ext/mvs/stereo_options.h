// Options of superpixel stereo, one struct for its stages (paper, Sec. "Linear Dense MVS").
#pragma once

#include <string>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct SuperpixelStereoOptions {
  // The linear solve. Inverse depths are divided by their median in the view, so that weights mean
  // the same at any scale of the world.
  double smoothness_weight = 0.02;   // λ_s of the paper; (0, 1e6]
  double continuity_weight = 0.005;  // λ_c of the paper; (0, 1e6]
  double color_sigma = 12.0;         // w_c = exp(-(|Δcolour| / σ)² / 2), grey levels; [1, 1000]
  double min_color_weight = 1e-3;  // w_c is never less, so that the system stays well-posed; (0, 1]
  int robust_passes = 3;           // solves with Cauchy-weighted SfM points; [1, 20]
  double max_support_px = 60.0;  // a triangle further from every SfM point (along the mesh, colour
                                 // edges counting extra) is marked unsupported; [1, 1e6]

  // Neighbouring views.
  int num_neighbors = 6;        // paper: 6; [1, 50]
  double good_angle_deg = 6.0;  // triangulation angle from which on a point counts fully; (0, 90]
  double max_angle_deg = 45.0;  // points seen under a larger angle do not count; (0, 180]

  // Confidence Γ. Chosen on simulated truth (docs/algorithms.md).
  double sigma_position_px = 4.0;     // σ_p; (0, 1e3]
  double sigma_normal_deg = 90.0;     // σ_n; (0, 1e3]
  double sigma_view = 0.1;            // σ_v, of cos²; (0, 10]
  double occlusion_tolerance = 0.03;  // a neighbour whose depth is smaller by this share is
                                      // occluded and no witness; (0, 1]

  // Fusion.
  double fusion_weight = 1.0;  // λ_u of the paper; (0, 1e6]
  int fusion_passes = 2;       // at most; 0: none; [0, 50]
  // Passes end earlier when fewer than fusion_moving_share of the facets of every view move by more
  // than fusion_tolerance of their depth.
  double fusion_tolerance = 0.002;     // [0, 1]
  double fusion_moving_share = 0.005;  // [0, 1]
  double fixed_confidence = 0.5;       // facets above keep their depth (paper: 0.5); [0, 1]
  double fusion_color_sigma =
      30.0;  // colour proximity of corresponding facets, grey levels; [1, 1000]
  double fusion_space_tolerance = 0.03;  // they agree when their depths differ by less than this
                                         // share; (0, 1]
  int fusion_step_px = 4;  // pixel grid on which facets of neighbours are looked up; [1, 64]

  // Photo-consistency: past the paper (mvs/photometric.h).
  bool photometric = true;
  double photometric_weight = 1.0;           // λ_p, of what the photos say of a plane; (0, 1e6]
  double photometric_min_correlation = 0.6;  // planes that correlate less give no rows; [0, 1]
  double sigma_photometric = 0.4;  // σ_c, of 1 - correlation in Γ's fourth cue; (0, 1e3]

  // Photos that keep their mesh when others come (PlanStereoUpdate).
  double keep_tolerance_px = 0.25;  // as long as nothing moved by more in a neighbour; 0: none
                                    // keeps it; [0, 100]
  double keep_new_points = 0.2;  // and the photo gained at most this share of SfM points; [0, 1e6]

  std::string Check() const;
};

// Section "SuperpixelStereo".
void BindOptions(OptionSet& set, SuperpixelStereoOptions* options);

}  // namespace colmap_ext
