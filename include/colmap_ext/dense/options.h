#pragma once

#include <string>

#include "colmap_ext/util/options.h"

namespace colmap_ext {

// Built-in dense stereo (CPU): pairs, matching, merging, filtering.
struct DenseStereoOptions {
  // Photos wider than this are scaled down, px; 0: full size. 0, or 64 … 65536.
  int max_width_px = 0;
  // Partners a photo is matched with, [1, 32].
  int num_partners = 6;
  // Triangulation angles at which shared points count fully, degrees, 0 < min <= good < max <= 90:
  // less below min_angle_deg (depth is inexact) and above good_angle_deg (photos look different);
  // none from max_angle_deg on.
  double min_angle_deg = 5;
  double good_angle_deg = 20;
  double max_angle_deg = 40;
  // Width of the first, coarsest level, where the whole depth range is searched, px; every further
  // level has twice the size and searches only around the level before. [64, 4096].
  int coarse_width_px = 480;
  // How far the finer levels search, px to either side of what the level before says, multiple of
  // 8, [8, 64].
  int residual_px = 16;
  // Side of the matching window, px, odd, [1, 11].
  int block_px = 5;
  // Cost margin by which the best match must win over the second best, percent, [0, 50].
  int uniqueness_percent = 5;
  // Depths of two pairs agree when they differ by less than this parallax, px, (0, 8].
  double agreement_px = 1.0;
  // Window over which depth is smoothed by a plane, and the normal comes from, px, odd, [3, 15].
  int plane_window_px = 7;
  // Another photo's map confirms a depth when the point comes back within this, px, (0, 8], and its
  // depth differs by less than this share, (0, 0.2]. COLMAP's stereo_fusion: 2 px, 0.01.
  double max_reprojection_px = 1.5;
  double max_depth_error = 0.01;
  // Photos that must agree on a depth, the photo itself counted, [1, 20].
  int min_photos = 2;
  // Every so many pixels of a photo (both ways) give a point of the fused cloud, [1, 16].
  int fusion_step_px = 2;
  // Memory that matching may use, MiB, [256, 1e6]: limits the photos worked on at the same time.
  int max_memory_mib = 4096;

  std::string Check() const;
};

// Section "DenseStereo".
void BindOptions(OptionSet& set, DenseStereoOptions* options);

}  // namespace colmap_ext
