// Splits a photo into convex polygons whose edges follow its line segments (paper, Sec. "Linear
// Dense MVS"; Duan and Lafarge 2015, "Image partitioning into convex polygons"), and these into
// triangles.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct SuperpixelOptions {
  // Polygons of a 640 x 368 photo, scaled by area for other sizes; [20, 20000]. About this many
  // come out (paper: about 1000).
  int target_polygons = 1000;
  double lsd_scale = 0.6;          // the LSD detector works on the photo scaled by this; [0.2, 1]
  double min_segment_px = 12.0;    // shorter line segments are ignored; [3, 1000]
  double anchor_offset_px = 1.5;   // distance of an anchor from its segment; [0.5, 10]
  double anchor_spacing_px = 9.0;  // distance of anchor pairs along a segment; [2, 100]
  // Anchors are at most this share of the polygons, the longest segments first; [0, 1].
  double max_anchor_share = 0.7;
  double merge_px = 1.5;   // vertices joined by a shorter edge become one; [0.1, 4]
  std::uint64_t seed = 1;  // of the point process in flat areas

  std::string Check() const;
};

// Section "SuperpixelSegmenter".
void BindOptions(OptionSet& set, SuperpixelOptions* options);

// A straight edge of the photo, COLMAP's pixel convention.
struct LineSegment {
  Eigen::Vector2d start_px;
  Eigen::Vector2d end_px;
  double Length() const { return (end_px - start_px).norm(); }
};

// LSD segments, pieces of one line joined, of at least options.min_segment_px, longest first.
std::vector<LineSegment> DetectLineSegments(const cv::Mat& bgr, const SuperpixelOptions& options);

// The partition of `bgr` (CV_8UC3, not empty). The triangles cover the image [0, W] x [0, H]
// exactly, without overlap; triangles of one superpixel are adjacent in the list. Same input, same
// output. Throws UsageError for options out of range and Error for an empty picture or another
// pixel type.
ImageMesh SegmentPhoto(const cv::Mat& bgr, const SuperpixelOptions& options);

}  // namespace colmap_ext
