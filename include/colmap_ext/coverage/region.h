// The region of interest: what has to be covered.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct RegionOptions {
  // "x_min,y_min,z_min,x_max,y_max,z_max", world (ENU), metres; empty: DefaultRegion finds it.
  std::string box;
  // GeoJSON file (RFC 7946) with the polygon that has to be covered; see ReadPolygon. With a box,
  // what lies in both; without, its height is that of the sparse points in it. Empty: none.
  std::filesystem::path polygon_path;
  // Width added on each side of the automatic region, part of its largest horizontal side, 0 … 1.
  double margin_ratio = 0.05;

  std::string Check() const;
};

// Section "RegionOfInterest".
void BindOptions(OptionSet& set, RegionOptions* options);

// Reads RegionOptions::box; throws UsageError for anything but six finite numbers, min < max.
BoundingBox ParseBox(const std::string& text);
// The text that ParseBox reads back exactly: what a session keeps.
std::string FormatBox(const BoundingBox& box);

// The rings of all Polygon and MultiPolygon geometries of a GeoJSON file (bare, in a Feature or in
// a FeatureCollection), in world x and y. Positions are longitude and latitude on WGS84, as the
// standard wants, for a frame with an origin on Earth (taken at the origin's height: a height in
// the file is not used); in a frame without one they are local x and y in metres. Throws Error
// naming the file and the place of what is wrong: no polygon, a ring of fewer than three corners or
// without area, a latitude out of range, a corner more than 100 km from the origin.
std::vector<PolygonRing> ReadPolygon(const std::filesystem::path& path, const WorldFrame& frame);

// The polygon or box of `options` when given, else bounds of what the photos look at (call it with
// the first photos, and keep the result):
//
// In a metric ENU frame, of the sparse points inside the horizontal convex hull of the camera
// centres (a flight around or over an object) those that stand out of the ground; ground outside
// the bounds of the object is so dropped. Ground: the 5th percentile of z of the points inside the
// hull. When nothing stands out, all points inside the hull. When few points lie inside the hull (a
// straight flight, a room photographed from its middle) and in frames whose vertical is unknown,
// the points are weighted by the photos that have them in the middle half of the picture. Each side
// lies at the 0.5th or 99.5th percentile, widened by the margin; the bottom is the ground less the
// margin.
//
// Throws Error when there are fewer than 10 points and no box is given, when none of them lies in
// the polygon, and when polygon and box do not meet.
RegionOfInterest DefaultRegion(const PhotoSet& photos, const WorldFrame& frame,
                               const RegionOptions& options);

}  // namespace colmap_ext
