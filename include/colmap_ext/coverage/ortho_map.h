// The coverage map seen from straight above, as a picture that maps can carry.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct OrthoMapOptions {
  // Edge of a pixel on the ground, metres, >= 0; 0: so that the longer side has 1000 pixels.
  double pixel_size_m = 0;
  // What the colours show: "class" (covered green, uncovered red, ignored blue) or "error" (the
  // predicted error from dark blue, 0, to yellow, max_error_mm and more or no prediction).
  std::string colors = "class";
  double max_error_mm = 100;  // > 0

  std::string Check() const;
};

// Section "OrthoMap".
void BindOptions(OptionSet& set, OrthoMapOptions* options);

struct OrthoMap {
  cv::Mat bgra;                // CV_8UC4, row 0 is the north; alpha 0: no surface
  Eigen::Vector2d upper_left;  // world x, y of the north-western corner of the first pixel
  double pixel_size_m = 0;
};

// Looks down on the surface over the region's box, a ray a pixel; what is met takes the colour of
// its nearest iso-point, shaded by its slope so that shapes can be made out. Walls that stand
// upright are not to be seen in it. Throws UsageError for wrong options, Error for more than 10^8
// pixels.
OrthoMap RenderOrthoMap(const Surface& surface, const CoverageMap& map,
                        const RegionOfInterest& region, const OrthoMapOptions& options);

// The PNG, beside it its world file (.pgw: how pixel centres become coordinates, as GDAL and GIS
// programs read it) and, for a frame with an origin on Earth, a .prj: then coordinates are UTM on
// WGS84, in the zone of the origin, and the world file carries the rotation between east of the
// frame and grid east (affine: within a millimetre for a map of 1 km). Otherwise they are local
// metres, and an old .prj is removed. Near the poles, where UTM ends, local too.
void WriteOrthoMap(const OrthoMap& map, const WorldFrame& frame, const std::filesystem::path& png);

}  // namespace colmap_ext
