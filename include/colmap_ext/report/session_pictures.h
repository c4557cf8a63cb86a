// The pictures of an iteration: surface, coverage map, flight path.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

// From where, how large, and of what.
struct PictureView {
  ViewDirection direction = {0.61, -0.56};  // from the south-west, 32 degrees down
  cv::Size size = {1280, 800};              // px
  // World points that have to be in the picture. Empty: each picture chooses what matters to it.
  std::vector<Eigen::Vector3d> focus;
};

// Colours of the classes; told apart also by those who do not see red and green.
Rgb ColorOf(CoverageClass coverage);

// The points of the map that have to be covered (not ignored), or the bulk of the mesh when there
// are none: what surface and coverage pictures show by default.
std::vector<Eigen::Vector3d> FocusOf(const CoverageMap& map, const TriangleMesh& mesh);

// The surface in the colours of the photos (neutral when it has none). `painter` holds
// surface.mesh. CV_8UC3.
cv::Mat RenderSurface(const MeshPainter& painter, const Surface& surface, const PictureView& view);

// The surface in the class colours of the nearest iso-points, with a legend. Grey: no iso-point is
// near.
cv::Mat RenderCoverageMap(const MeshPainter& painter, const CoverageMap& map,
                          const PictureView& view);

// What the flight picture shows beside the surface.
struct FlightPicture {
  std::vector<PosedPhoto> photos;  // taken so far; pixels are not needed
  std::vector<PlannedView> views;  // next views; numbered in the order of the path
  FlightPath path;                 // may be empty
  PinholeCamera planned_camera;    // of the next photos; that of the first photo when width is 0
};

// Existing photos as thin frusta, next views as filled ones with their number, the path with
// arrows; what is hidden is dimmed. Views that the path does not reach are grey.
cv::Mat RenderFlightPath(const MeshPainter& painter, const FlightPicture& flight,
                         const PictureView& view);

}  // namespace colmap_ext
